// calot compare: recomputation, the paper's update and the exact one, beside each other.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/comparison.h"
#include "app/staged_folder.h"
#include "app/terminal.h"
#include "calot/base/files.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/picture/picture.h"

namespace calot {
namespace {

constexpr double mm = 1000;

struct CompareArguments {
  std::filesystem::path model, output;
  std::vector<std::string> forces;
  CutArguments cut;
};

double percent_of_peak(const Comparison& comparison, const MethodResult& method) {
  return comparison.peak > 0 ? 100 * method.distance.max / comparison.peak : 0;
}

void print_table(const Comparison& comparison) {
  say("distance from the recomputed displacement (its peak: " + number_text(mm * comparison.peak) + " mm)");
  say("method        usable [s]      max [mm]     mean [mm]      std [mm]   max/peak [%]");
  for (const MethodResult& method : comparison.methods) {
    std::array<char, 160> line;
    std::snprintf(line.data(), line.size(), "%-10s %13.4g %13.4g %13.4g %13.4g %14.4g", method.name.c_str(),
                  method.seconds, mm * method.distance.max, mm * method.distance.mean, mm * method.distance.std,
                  percent_of_peak(comparison, method));
    say(line.data());
  }
}

nlohmann::ordered_json to_json(const Comparison& comparison) {
  auto rows = nlohmann::ordered_json::array();
  for (const MethodResult& method : comparison.methods)
    rows.push_back({{"method", method.name},
                    {"seconds", method.seconds},
                    {"max_mm", mm * method.distance.max},
                    {"mean_mm", mm * method.distance.mean},
                    {"std_mm", mm * method.distance.std},
                    {"max_percent_of_peak", percent_of_peak(comparison, method)}});
  return {{"peak_displacement_mm", mm * comparison.peak},
          {"tets_removed", comparison.edit.removed.size()},
          {"vertices", comparison.mesh.vertex_count()},
          {"methods", rows},
          {"notes", comparison.edit.report.notes}};
}

void write_csv(const std::filesystem::path& path, const nlohmann::ordered_json& rows) {
  write_file(path, [&](std::ostream& out) {
    out << "method,seconds,max_mm,mean_mm,std_mm,max_percent_of_peak\n";
    for (const auto& row : rows) {
      out << row["method"].get<std::string>();
      for (const char* key : {"seconds", "max_mm", "mean_mm", "std_mm", "max_percent_of_peak"})
        out << ',' << row[key].dump();
      out << '\n';
    }
  });
}

/// 1, 2 or 5 times a power of ten that makes the peak displacement about a tenth of the size; 1 if it is large already.
double magnification(double peak, double size) {
  const double wanted = peak > 0 ? 0.1 * size / peak : 1;
  if (wanted <= 2) return 1;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double digit : {5.0, 2.0})
    if (wanted >= digit * power) return digit * power;
  return power;
}

double diagonal(const TetMesh& mesh) {
  Vec3 low = mesh.positions.front(), high = low;
  for (const Vec3& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

/// Where the surface goes, `factor` times as far.
std::vector<Vec3> displaced(const Surface& surface, const Displacements& u, double factor) {
  std::vector<Vec3> positions = surface.positions;
  for (std::size_t v = 0; v < positions.size(); ++v) positions[v] += factor * u[surface.vertex_of_mesh[v].index()];
  return positions;
}

/// Two pictures: the paper's answer and the exact one, each over the recomputed one.
void write_overlay(const std::filesystem::path& path, const Comparison& comparison) {
  const Surface surface = boundary_surface(comparison.mesh);
  const double factor = magnification(comparison.peak, diagonal(comparison.mesh));
  const auto& [recompute, paper, exact] = comparison.methods;
  const std::vector<Vec3> truth = displaced(surface, recompute.u, factor),
                          by_paper = displaced(surface, paper.u, factor), exactly = displaced(surface, exact.u, factor);
  const auto item = [&](const std::vector<Vec3>& positions, const Vec3& color, double opacity, const char* label) {
    return PictureItem{.surface = &surface, .positions = positions, .color = color, .opacity = opacity, .label = label};
  };
  const PictureItem below = item(truth, {0.25, 0.45, 0.80}, 1, "recomputed");
  const PictureItem of_paper = item(by_paper, {0.90, 0.45, 0.15}, 0.5, "paper's update");
  const PictureItem of_exact = item(exactly, {0.20, 0.65, 0.35}, 0.5, "exact update");
  PictureOptions options{.width = 960, .height = 960, .frame = frame_of({below, of_paper, of_exact})};
  if (factor != 1) options.caption = "displacements magnified " + number_text(factor) + " times";
  options.title = "paper: up to " + number_text(mm * paper.distance.max, 3) + " mm off";
  const Image left = render_picture({below, of_paper}, options);
  options.title = "exact: up to " + number_text(mm * exact.distance.max, 3) + " mm off";
  write_png(path, beside({left, render_picture({below, of_exact}, options)}));
}

void write_fields(const std::filesystem::path& path, const Comparison& comparison) {
  std::vector<VertexArray> arrays;
  for (const MethodResult& method : comparison.methods) {
    VertexArray array{"displacement_" + method.name, 3, {}};
    for (const Vec3& u : method.u) array.values.insert(array.values.end(), u.begin(), u.end());
    arrays.push_back(std::move(array));
  }
  write_mesh(path, comparison.mesh, arrays);
}

void run_compare(const CompareArguments& arguments) {
  StagedFolder folder(arguments.output);
  const std::vector<Blade> blades = arguments.cut.blades();
  std::vector<PointForce> forces;
  for (const std::string& text : arguments.forces) forces.push_back(parse_force(text));
  const Model model = load_model(arguments.model);
  check_forces(forces, model);
  const Comparison comparison = compare(model, blades, arguments.cut.options(), forces, &terminal_progress());
  const nlohmann::ordered_json json = to_json(comparison);
  const auto write = [&](const std::filesystem::path& place) {
    write_csv(place / "compare.csv", json["methods"]);
    write_file(place / "compare.json", [&](std::ostream& out) { out << json.dump(2) << '\n'; });
    write_fields(place / "compare.vtu", comparison);
    write_overlay(place / "compare.png", comparison);
  };
  folder.fill(write, {"compare.csv", "compare.vtu", "compare.png", "compare.json"});
  if (comparison.edit.removed.empty()) warn("the cut removes nothing");
  warn_about_idle(forces, model);
  for (const std::string& note : comparison.edit.report.notes) say("note: " + note);
  print_table(comparison);
  say("wrote " + folder.target().string());
}

}  // namespace

void add_compare_command(CLI::App& app) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command =
      app.add_subcommand("compare", "A cut recomputed, by the paper's update, and exactly: how far apart");
  command->add_option("MODEL", arguments->model, "model.toml")->required();
  arguments->cut.add_to(*command);
  add_repeated(*command, "--force", arguments->forces, "V,fx,fy,fz: newtons on vertex V of the uncut mesh", true);
  command->add_option("-o,--output", arguments->output, "folder for compare.csv, .json, .png and .vtu")
      ->required()
      ->type_name("DIR");
  command->footer("Example:\n  calot compare model.toml --plane 10mm,0,0,1,0,0 --force 12,0,-0.5,0 -o comparison");
  command->callback([arguments] { run_compare(*arguments); });
}

}  // namespace calot
