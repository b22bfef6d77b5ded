// calot cut: a model and its compliance → the cut model and the compliance of that.
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/full_matrix.h"
#include "app/staged_folder.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/compliance/compliance_file.h"
#include "calot/fem/model_file.h"
#include "calot/fem/support.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace {

constexpr double drift_limit = 1e-9;  // of the probe; beyond it the matrix is computed anew

struct CommandArguments {
  std::filesystem::path model, compliance, output;
  std::string method = "exact", mode = "remove";
  CutArguments cut;
};

/// Everything a cut leads to, by whichever method.
struct CutResult {
  Edit edit;
  Model model;  // after the cut
  Remap remap = {};
  std::optional<Compliance> compliance = {};  // exact and recompute
  FullCompliance full = {};                   // paper
  bool float32 = false;                       // as in the file that was read
  std::size_t rank = 0;
  double select = 0, usable = 0, fold = 0;  // seconds
  double probe = 0;
  std::vector<std::string> notes = {};
};

/// Applies the edit to the model; refuses what leaves nothing, or a static part that can move.
StiffnessChange apply_edit(CutResult& result) {
  if (result.edit.removed.size() == result.model.mesh().tet_count())
    throw FailedError("", "the cut removes every tetrahedron, so nothing is left", "cut less");
  StiffnessChange change = result.model.apply(result.edit);
  result.remap = change.remap;
  if (!change.unsupported.empty())
    throw Unsupported("", "the cut leaves a static part without support: " + change.unsupported,
                      "fix it in the model, or use a time_step > 0");
  return change;
}

void cut_exactly(const CommandArguments& arguments, CutResult& result) {
  result.float32 = read_compliance_info(arguments.compliance, result.model).float32;
  result.compliance = load_compliance(arguments.compliance, result.model, &terminal_progress());
  Stopwatch watch;
  const StiffnessChange change = apply_edit(result);
  result.rank = result.compliance->update(change).rank;
  result.usable = watch.lap();
  // A factor that is written must not keep rows of vertices that are gone.
  if (result.compliance->backend() == Backend::sparse)
    result.compliance->refresh();
  else
    // A factor is stored without the rows of vertices that are gone, so it is ordered anew.
    if (result.compliance->backend() == Backend::sparse)
      result.compliance->refresh(&terminal_progress());
    else
      result.compliance->fold();
  result.fold = watch.lap();
  result.probe = result.compliance->probe();
  // What an ill-conditioned model can't do better is no drift.
  if (result.probe <= drift_limit ||
      result.probe <= 10 * std::numeric_limits<double>::epsilon() * result.compliance->condition())
    return;
  result.notes.push_back("the probe found a residual of " + number_text(result.probe, 2) +
                         " after the update, so the compliance was computed anew");
  watch.lap();
  result.compliance->refresh(&terminal_progress());
  result.fold += watch.lap();
  result.probe = result.compliance->probe();
}

void cut_as_the_paper(const CommandArguments& arguments, CutResult& result) {
  const ComplianceFileInfo info = read_compliance_info(arguments.compliance, result.model);
  result.float32 = info.float32;
  result.full = load_whole_matrix(arguments.compliance, result.model);
  Stopwatch watch;
  apply_edit(result);
  paper_update(result.full, result.remap.orphaned, result.model.mesh());
  result.usable = watch.lap();
  result.probe = probe_residual(result.full, result.model);
}

void cut_and_recompute(const CommandArguments& arguments, CutResult& result) {
  const ComplianceFileInfo info = read_compliance_info(arguments.compliance, result.model);
  result.float32 = info.float32;
  Stopwatch watch;
  apply_edit(result);
  result.compliance = precompute(result.model, {.backend = info.backend}, &terminal_progress());
  result.usable = watch.lap();
  result.probe = result.compliance->probe();
}

CutResult run_method(const CommandArguments& arguments) {
  const std::vector<Blade> blades = arguments.cut.blades();
  Model model = load_model(arguments.model);
  Stopwatch watch;
  Edit edit = cut(model.mesh(), blades, arguments.cut.options());
  CutResult result{.edit = std::move(edit), .model = std::move(model)};
  result.select = watch.lap();
  result.notes = result.edit.report.notes;
  if (arguments.method == "exact") cut_exactly(arguments, result);
  if (arguments.method == "paper") cut_as_the_paper(arguments, result);
  if (arguments.method == "recompute") cut_and_recompute(arguments, result);
  return result;
}

// ---- what is written ----

/// A part is supported if its own fixed vertices hold it, or if all parts are held through each other.
nlohmann::ordered_json describe_parts(const Model& model) {
  const Parts parts = face_connected_parts(model.mesh());
  const bool all_held = unsupported_part(model.mesh(), model.fixed()).empty();
  auto list = nlohmann::ordered_json::array();
  for (std::size_t p = 0; p < parts.count(); ++p) {
    TetMesh part;
    part.positions = model.mesh().positions;
    for (const TetId t : parts.tets[p]) {
      part.tets.push_back(model.mesh().tet(t));
      part.regions.push_back(model.mesh().regions[t.index()]);
    }
    list.push_back({{"vertices", parts.vertices[p].size()},
                    {"tets", parts.tets[p].size()},
                    {"supported", all_held || unsupported_part(part, model.fixed()).empty()}});
  }
  return list;
}

nlohmann::ordered_json summarise(const CommandArguments& arguments, const CutResult& result, double total) {
  return {{"method", arguments.method},
          {"mode", arguments.mode},
          {"tets_removed", result.edit.removed.size()},
          {"vertices_removed", result.remap.orphaned.size()},
          {"rank", result.rank},
          {"parts", describe_parts(result.model)},
          {"seconds", {{"select", result.select}, {"usable", result.usable}, {"fold", result.fold}, {"total", total}}},
          {"probe_residual", result.probe},
          {"hanging", result.edit.report.hanging.size() - result.edit.report.cleaned},
          {"cleaned", result.edit.report.cleaned},
          {"notes", result.notes}};
}

void write_vertex_map(const std::filesystem::path& path, const Remap& remap) {
  write_file(path, [&](std::ostream& out) {
    out << "old,new\n";
    for (std::size_t v = 0; v < remap.vertex_to_new.size(); ++v) {
      out << v << ',';
      if (remap.vertex_to_new[v].valid())
        out << remap.vertex_to_new[v].value << '\n';
      else
        out << "-1\n";
    }
  });
}

/// The compliance is stored for the model as its files give it back, so that the two fit to the last bit.
void write_compliance(const std::filesystem::path& folder, const CutResult& result) {
  const Model written = load_model(folder / "model.toml");
  if (result.compliance)
    save_compliance(folder / "C.h5", *result.compliance, written, result.float32, &terminal_progress());
  else
    save_full_compliance(folder / "C.h5", result.full, written, result.float32, &terminal_progress(), true);
}

void write_results(const CommandArguments& arguments, const CutResult& result, StagedFolder& output,
                   Stopwatch& since_start) {
  const auto write = [&](const std::filesystem::path& folder) {
    write_mesh(folder / "cut.msh", result.model.mesh());
    save_model(folder / "model.toml", result.model, "cut.msh");
    write_compliance(folder, result);
    write_vertex_map(folder / "vertex_map.csv", result.remap);
    const std::string summary = summarise(arguments, result, since_start.lap()).dump(2);
    write_file(folder / "summary.json", [&](std::ostream& out) { out << summary << '\n'; });
  };
  output.fill(write, {"cut.msh", "model.toml", "C.h5", "vertex_map.csv", "summary.json"});
}

/// The output has a model.toml and a C.h5 of its own: they must not fall on the ones being read.
void check_folder(const CommandArguments& arguments) {
  std::error_code code;
  for (const std::filesystem::path& input : {arguments.model, arguments.compliance})
    if (std::filesystem::equivalent(input.has_parent_path() ? input.parent_path() : ".", arguments.output, code))
      throw InputError(arguments.output.string(), "holds " + input.filename().string() + ", which would be overwritten",
                       "write into another folder");
}

void run_cut(const CommandArguments& arguments) {
  if (arguments.mode == "split")
    throw InputError("--mode split", "is not there yet: it comes with the simulation", "use --mode remove");
  Stopwatch since_start;
  StagedFolder folder(arguments.output);
  check_folder(arguments);
  const CutResult result = run_method(arguments);
  write_results(arguments, result, folder, since_start);
  if (result.edit.removed.empty()) warn("the cut removes nothing");
  for (const std::string& note : result.notes) say("note: " + note);
  say("removed " + std::to_string(result.edit.removed.size()) + " tetrahedra and " +
      std::to_string(result.remap.orphaned.size()) + " vertices; " +
      std::to_string(face_connected_parts(result.model.mesh()).count()) + " parts; usable after " +
      seconds_text(result.usable) + "; residual " + number_text(result.probe, 2));
  say("wrote " + folder.target().string());
}

}  // namespace

void add_cut_command(CLI::App& app) {
  auto arguments = std::make_shared<CommandArguments>();
  CLI::App* command = app.add_subcommand("cut", "Cut a model and bring its compliance up to date");
  command->add_option("MODEL", arguments->model, "model.toml")->required();
  command->add_option("COMPLIANCE", arguments->compliance, "its C.h5")->required();
  arguments->cut.add_to(*command);
  command->add_option("--method", arguments->method, "exact; paper: its approximate update; recompute: from scratch")
      ->check(CLI::IsMember({"exact", "paper", "recompute"}))
      ->capture_default_str();
  command->add_option("--mode", arguments->mode, "remove: what the blade crosses goes")
      ->check(CLI::IsMember({"remove", "split"}))
      ->capture_default_str();
  command
      ->add_option("-o,--output", arguments->output,
                   "folder for cut.msh, model.toml, C.h5, summary.json and vertex_map.csv")
      ->required()
      ->type_name("DIR");
  command->footer("Example:\n  calot cut model.toml C.h5 --plane 10mm,0,0,1,0,0 --region \"cystic duct\" -o cut");
  command->callback([arguments] { run_cut(*arguments); });
}

}  // namespace calot
