// calot solve: forces → the displacement of every vertex.
#include <charconv>
#include <filesystem>
#include <memory>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/full_matrix.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/compliance/compliance_file.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace {

struct SolveArguments {
  std::filesystem::path model, compliance, output;
  std::vector<std::string> forces;
};

/// Shortest texts that read back to the same doubles.
void write_csv(const std::filesystem::path& path, const Displacements& u) {
  write_file(path, [&](std::ostream& out) {
    out << "ux,uy,uz\n";
    for (const Vec3& displacement : u)
      for (int axis = 0; axis < 3; ++axis) {
        char text[40];
        const auto end = std::to_chars(text, text + sizeof text, displacement[axis]).ptr;
        out.write(text, end - text);
        out.put(axis < 2 ? ',' : '\n');
      }
  });
}

void write_vtu(const std::filesystem::path& path, const Model& model, const Displacements& u) {
  VertexArray array{"displacement", 3, {}};
  for (const Vec3& displacement : u) array.values.insert(array.values.end(), displacement.begin(), displacement.end());
  write_mesh(path, model.mesh(), {array});
}

Displacements solve_with_file(const std::filesystem::path& path, const Model& model,
                              const std::vector<PointForce>& forces) {
  if (!read_compliance_info(path, model).approximate)
    return load_compliance(path, model, &terminal_progress()).solve(forces);
  warn(path.string() + " holds the paper's approximate update; the answer is as approximate");
  return multiply(load_full_compliance(path, model, &terminal_progress()), forces);
}

void run_solve(const SolveArguments& arguments) {
  check_output_file(arguments.output);
  const std::string ending = ending_of(arguments.output);
  if (ending != ".csv" && ending != ".vtu")
    throw InputError(arguments.output.string(), "unknown ending \"" + ending + "\"", "use .csv or .vtu");
  std::vector<PointForce> forces;
  for (const std::string& text : arguments.forces) forces.push_back(parse_force(text));
  const Model model = load_model(arguments.model);
  check_forces(forces, model);
  const Displacements u = solve_with_file(arguments.compliance, model, forces);
  if (ending == ".csv")
    write_csv(arguments.output, u);
  else
    write_vtu(arguments.output, model, u);
  warn_about_idle(forces, model);
  double peak = 0;
  for (const Vec3& displacement : u) peak = std::max(peak, displacement.norm());
  say("largest displacement " + number_text(1000 * peak) + " mm; wrote " + arguments.output.string());
}

}  // namespace

void add_solve_command(CLI::App& app) {
  auto arguments = std::make_shared<SolveArguments>();
  CLI::App* command = app.add_subcommand("solve", "Displacement of every vertex under forces");
  command->add_option("MODEL", arguments->model, "model.toml")->required();
  command->add_option("COMPLIANCE", arguments->compliance, "its C.h5")->required();
  add_repeated(*command, "--force", arguments->forces, "V,fx,fy,fz: newtons on vertex V", true);
  command->add_option("-o,--output", arguments->output, ".csv (header, then ux,uy,uz in m for each vertex) or .vtu")
      ->required()
      ->type_name("u.csv");
  command->footer("Example:\n  calot solve model.toml C.h5 --force 12,0,-0.5,0 -o u.csv");
  command->callback([arguments] { run_solve(*arguments); });
}

}  // namespace calot
