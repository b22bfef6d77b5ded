// calot precompute: model.toml → C.h5.
#include <filesystem>
#include <memory>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/memory.h"
#include "calot/compliance/compliance_file.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"

namespace calot {
namespace {

struct PrecomputeArguments {
  std::filesystem::path model, output;
  std::string backend = "dense";
  bool float32 = false;
};

void describe(const Model& model) {
  std::size_t fixed = 0;
  for (const std::uint8_t flag : model.fixed()) fixed += flag;
  const double step = model.dynamics().time_step;
  say("model: " + std::to_string(model.mesh().vertex_count()) + " vertices (" + std::to_string(fixed) + " fixed), " +
      std::to_string(model.mesh().tet_count()) + " tetrahedra, " +
      (step > 0 ? "step " + number_text(1000 * step) + " ms" : "static"));
  const std::size_t doubled = validate(model.mesh()).coincident.size();
  if (doubled == 0) return;
  say("note: " + std::to_string(doubled) + " vertices are at exactly the place of an earlier one, as after a cut; " +
      std::to_string(face_connected_parts(model.mesh()).count()) + " parts");
}

void run_precompute(const PrecomputeArguments& arguments) {
  check_output_file(arguments.output);
  const Model model = load_model(arguments.model);
  const PrecomputeOptions options{arguments.backend == "sparse" ? Backend::sparse : Backend::dense};
  if (options.backend == Backend::sparse && arguments.float32)
    throw InputError("--float32", "goes with the dense backend only", "leave one of the two out");
  describe(model);
  say("memory needed: " + readable_bytes(precompute_memory(model, options)) + " of " +
      readable_bytes(available_memory()) + " available");
  std::cout.flush();  // before the work starts, also into a pipe
  Stopwatch watch;
  const Compliance compliance = precompute(model, options, &terminal_progress());
  say("computed in " + seconds_text(watch.lap()) + ", residual " + number_text(compliance.probe(), 2));
  watch.lap();
  save_compliance(arguments.output, compliance, model, arguments.float32, &terminal_progress());
  say("wrote " + arguments.output.string() + " (" + readable_bytes(std::filesystem::file_size(arguments.output)) +
      ") in " + seconds_text(watch.lap()));
}

}  // namespace

void add_precompute_command(CLI::App& app) {
  auto arguments = std::make_shared<PrecomputeArguments>();
  CLI::App* command = app.add_subcommand("precompute", "Compute the compliance of a model");
  command->add_option("MODEL", arguments->model, "model.toml")->required();
  command->add_option("-o,--output", arguments->output, "the compliance file to write")->required()->type_name("C.h5");
  command->add_option("--backend", arguments->backend, "dense: the whole matrix; sparse: the factor, small")
      ->check(CLI::IsMember({"dense", "sparse"}))
      ->capture_default_str();
  command->add_flag("--float32", arguments->float32, "store 4-byte reals: half the size, 7 digits");
  command->footer("Example:\n  calot precompute model.toml -o C.h5");
  command->callback([arguments] { run_precompute(*arguments); });
}

}  // namespace calot
