// calot cut: a model and its compliance → the cut model and the compliance of that.
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/full_matrix.h"
#include "app/lineage.h"
#include "app/staged_folder.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/compliance/compliance_file.h"
#include "calot/cut/split.h"
#include "calot/fem/model_file.h"
#include "calot/fem/support.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace {

constexpr const char* origins_file = "vertex_origins.csv";
constexpr double drift_limit = 1e-9;  // of the probe; beyond it the matrix is computed anew

struct CommandArguments {
  std::filesystem::path model, compliance, output;
  std::string method = "exact", mode = "remove";
  CutArguments cut;
  [[nodiscard]] bool splits() const { return mode == "split"; }
};

/// Everything a cut leads to, by whichever method.
struct CutResult {
  std::vector<TopologyEdit> edits = {};  // one after another, each in numbers of the mesh that the ones before leave
  std::vector<Remap> remaps = {};        // of each
  Model model;                           // after the cut
  Lineage lineage;
  std::optional<Compliance> compliance = {};  // exact and recompute
  FullCompliance full = {};                   // paper
  bool float32 = false;                       // as in the file that was read
  std::size_t rank = 0;
  double select = 0, usable = 0, fold = 0;  // seconds
  double probe = 0;
  CutReport removal = {};  // --mode remove
  SplitReport split = {};  // --mode split, of all blades together
  std::vector<std::string> notes = {};
};

// ---- which edits ----

/// All blades at once: what one removes doesn't change what the others cross.
void find_removal(const CutArguments& cut_arguments, CutResult& result) {
  const std::vector<Blade> blades = cut_arguments.blades();
  Stopwatch watch;
  Edit edit = cut(result.model.mesh(), blades, cut_arguments.options());
  result.select = watch.lap();
  result.removal = std::move(edit.report);
  result.notes = result.removal.notes;
  result.edits.push_back(std::move(edit));
}

void add_up(SplitReport& sum, const SplitReport& one) {
  sum.separated += one.separated;
  sum.angle_before = std::min(sum.angle_before, one.angle_before);
  sum.angle_after = std::min(sum.angle_after, one.angle_after);
  sum.too_sharp += one.too_sharp;
  sum.largest_distance = std::max(sum.largest_distance, one.largest_distance);
  sum.volume_change += one.volume_change;
}

/// One blade after another, each in what the ones before left.
void find_splits(const CutArguments& cut_arguments, CutResult& result) {
  const std::vector<Blade> blades = cut_arguments.blades();
  Model model = result.model;
  for (std::size_t b = 0; b < blades.size(); ++b) {
    Stopwatch watch;
    SplitEdit edit = split(model.mesh(), blades[b], {.region = cut_arguments.region, .fixed = model.fixed()});
    result.select += watch.lap();
    add_up(result.split, edit.report);
    for (const std::string& note : edit.report.notes)
      result.notes.push_back(blades.size() == 1 ? note : cut_arguments.name_of(b) + ": " + note);
    if (b + 1 < blades.size()) model.apply(edit);
    result.edits.push_back(std::move(edit));
  }
}

// ---- the three methods ----

/// Applies the edits to the model and hands each change on; refuses what leaves nothing, or a static part that can
/// move.
template <class Take>
void apply_edits(CutResult& result, const Take& take) {
  for (const TopologyEdit& edit : result.edits) {
    if (edit.removed.size() == result.model.mesh().tet_count() && edit.tets.empty())
      throw FailedError("", "the cut removes every tetrahedron, so nothing is left", "cut less");
    StiffnessChange change = result.model.apply(edit);
    if (!change.unsupported.empty())
      throw Unsupported("", "the cut leaves a static part without support: " + change.unsupported,
                        "fix it in the model, or use a time_step > 0");
    take(change);
    result.remaps.push_back(std::move(change.remap));
  }
}

void cut_exactly(const CommandArguments& arguments, CutResult& result) {
  result.float32 = read_compliance_info(arguments.compliance, result.model).float32;
  result.compliance = load_compliance(arguments.compliance, result.model, &terminal_progress());
  Stopwatch watch;
  apply_edits(result, [&](const StiffnessChange& change) {
    result.rank += result.compliance->update(change).rank;
    result.usable += watch.lap();
    // Each blade has a correction of its own: one of all of them together costs the cube of its size.
    if (result.remaps.size() + 1 < result.edits.size()) result.compliance->fold();
    result.fold += watch.lap();
  });
  // A factor is stored without the rows of vertices that are gone, so it is ordered anew.
  if (result.compliance->backend() == Backend::sparse)
    result.compliance->refresh(&terminal_progress());
  else
    result.compliance->fold();
  result.fold += watch.lap();
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
  apply_edits(result, [&](const StiffnessChange& change) {
    paper_update(result.full, change.remap.orphaned, result.model.mesh());
  });
  result.usable = watch.lap();
  result.probe = probe_residual(result.full, result.model);
}

void cut_and_recompute(const CommandArguments& arguments, CutResult& result) {
  const ComplianceFileInfo info = read_compliance_info(arguments.compliance, result.model);
  result.float32 = info.float32;
  Stopwatch watch;
  apply_edits(result, [](const StiffnessChange&) {});
  result.compliance = precompute(result.model, {.backend = info.backend}, &terminal_progress());
  result.usable = watch.lap();
  result.probe = result.compliance->probe();
}

CutResult run_method(const CommandArguments& arguments) {
  (void)arguments.cut.blades();  // refuses what can't be read before a large mesh is
  Model model = load_model(arguments.model);
  Lineage lineage(model.mesh());
  CutResult result{.model = std::move(model), .lineage = std::move(lineage)};
  if (arguments.splits())
    find_splits(arguments.cut, result);
  else
    find_removal(arguments.cut, result);
  if (arguments.method == "exact") cut_exactly(arguments, result);
  if (arguments.method == "paper") cut_as_the_paper(arguments, result);
  if (arguments.method == "recompute") cut_and_recompute(arguments, result);
  for (const Remap& remap : result.remaps) result.lineage.follow(remap);
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

void describe_removal(const CutResult& result, nlohmann::ordered_json& summary) {
  summary["hanging"] = result.removal.hanging.size() - result.removal.cleaned;
  summary["cleaned"] = result.removal.cleaned;
}

void describe_split(const CutResult& result, nlohmann::ordered_json& summary) {
  const SplitReport& split = result.split;
  const bool changed = result.lineage.tets_removed() > 0 || result.lineage.vertices_moved() > 0;
  const auto angle = [&](double degrees) { return changed ? nlohmann::ordered_json(degrees) : nullptr; };
  summary["faces_opened"] = split.separated;
  summary["vertices_added"] = result.lineage.vertices_added();
  summary["vertices_moved"] = result.lineage.vertices_moved();
  summary["tets_added"] = result.lineage.tets_added();
  summary["volume_change"] = split.volume_change;
  summary["smallest_angle"] = {{"before", angle(split.angle_before)}, {"after", angle(split.angle_after)}};
  summary["flatness"] = split.largest_distance;
}

nlohmann::ordered_json summarise(const CommandArguments& arguments, const CutResult& result, double total) {
  nlohmann::ordered_json summary = {
      {"method", arguments.method},
      {"mode", arguments.mode},
      {"tets_removed", result.lineage.tets_removed()},
      {"vertices_removed", result.lineage.vertices_removed()},
      {"rank", result.rank},
      {"parts", describe_parts(result.model)},
      {"seconds", {{"select", result.select}, {"usable", result.usable}, {"fold", result.fold}, {"total", total}}},
      {"probe_residual", result.probe}};
  if (arguments.splits())
    describe_split(result, summary);
  else
    describe_removal(result, summary);
  summary["notes"] = result.notes;
  return summary;
}

void write_vertex_map(const std::filesystem::path& path, const std::vector<VertexId>& vertex_to_new) {
  write_file(path, [&](std::ostream& out) {
    out << "old,new\n";
    for (std::size_t v = 0; v < vertex_to_new.size(); ++v) {
      out << v << ',';
      if (vertex_to_new[v].valid())
        out << vertex_to_new[v].value << '\n';
      else
        out << "-1\n";
    }
  });
}

/// Of the vertices that are not old ones in their old place. Weights are the shortest texts that read back the same.
void write_origins(const std::filesystem::path& path, const Lineage& lineage) {
  write_file(path, [&](std::ostream& out) {
    out << "new,old,weight\n";
    for (std::size_t v = 0; v < lineage.origins().size(); ++v) {
      if (lineage.in_place(VertexId(v))) continue;
      for (const Lineage::Share& share : lineage.origins()[v]) {
        char text[40];
        const auto end = std::to_chars(text, text + sizeof text, share.weight).ptr;
        out << v << ',' << share.old.value << ',';
        out.write(text, end - text);
        out << '\n';
      }
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
    write_vertex_map(folder / "vertex_map.csv", result.lineage.vertex_to_new());
    if (arguments.splits()) write_origins(folder / origins_file, result.lineage);
    const std::string summary = summarise(arguments, result, since_start.lap()).dump(2);
    write_file(folder / "summary.json", [&](std::ostream& out) { out << summary << '\n'; });
  };
  std::vector<std::string> files{"cut.msh", "model.toml", "C.h5", "vertex_map.csv", "summary.json"};
  if (arguments.splits()) files.insert(files.end() - 1, origins_file);
  output.fill(write, files);
  std::error_code code;  // of an earlier split into the same folder; it says nothing of this cut
  if (!arguments.splits()) std::filesystem::remove(output.target() / origins_file, code);
}

/// The output has a model.toml and a C.h5 of its own: they must not fall on the ones being read.
void check_folder(const CommandArguments& arguments) {
  std::error_code code;
  for (const std::filesystem::path& input : {arguments.model, arguments.compliance})
    if (std::filesystem::equivalent(input.has_parent_path() ? input.parent_path() : ".", arguments.output, code))
      throw InputError(arguments.output.string(), "holds " + input.filename().string() + ", which would be overwritten",
                       "write into another folder");
}

/// Refuses what doesn't go together, before anything is read.
void check_combination(const CommandArguments& arguments) {
  if (!arguments.splits()) return;
  if (arguments.method == "paper")
    throw InputError("--method paper", "can't follow a split: it strikes vertices and adds none",
                     "use --method exact or recompute, or --mode remove");
  if (arguments.cut.clean)
    throw InputError("--clean", "removes tetrahedra, which --mode split never does", "leave one of the two out");
}

std::string what_was_done(const CommandArguments& arguments, const CutResult& result) {
  const auto tets = std::to_string(result.lineage.tets_removed());
  if (!arguments.splits())
    return "removed " + tets + " tetrahedra and " + std::to_string(result.lineage.vertices_removed()) + " vertices";
  return "opened " + std::to_string(result.split.separated) + " faces; " +
         std::to_string(result.lineage.vertices_added()) + " vertices added; " + tets + " tetrahedra became " +
         std::to_string(result.lineage.tets_added());
}

void run_cut(const CommandArguments& arguments) {
  check_combination(arguments);
  Stopwatch since_start;
  StagedFolder folder(arguments.output);
  check_folder(arguments);
  const CutResult result = run_method(arguments);
  write_results(arguments, result, folder, since_start);
  if (arguments.splits() && result.split.separated == 0) warn("the cut opens nothing");
  if (!arguments.splits() && result.lineage.tets_removed() == 0) warn("the cut removes nothing");
  for (const std::string& note : result.notes) say("note: " + note);
  say(what_was_done(arguments, result) + "; " + std::to_string(face_connected_parts(result.model.mesh()).count()) +
      " parts; usable after " + seconds_text(result.usable) + "; residual " + number_text(result.probe, 2));
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
  command
      ->add_option("--mode", arguments->mode,
                   "remove: what the blade crosses goes, as in the paper; split: the mesh is parted "
                   "along the blade and keeps its volume")
      ->check(CLI::IsMember({"remove", "split"}))
      ->capture_default_str();
  command
      ->add_option(
          "-o,--output", arguments->output,
          "folder for cut.msh, model.toml, C.h5, summary.json and vertex_map.csv; a split adds vertex_origins.csv")
      ->required()
      ->type_name("DIR");
  command->footer(
      "Example:\n  calot cut model.toml C.h5 --plane 10mm,0,0,1,0,0 --region \"cystic duct\" --mode split -o cut");
  command->callback([arguments] { run_cut(*arguments); });
}

}  // namespace calot
