// calot patient: CT and labels become a patient's folder, or a folder is checked.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/patient_preview.h"
#include "app/staged_folder.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/memory.h"
#include "calot/compliance/compliance_file.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/patient/make_patient.h"

namespace calot {
namespace {

namespace fs = std::filesystem;

struct PatientArguments {
  PatientRequest request;
  fs::path folder, check, write_table;
  std::string overlap = "refuse", surface_unit = "mm";
  bool compliance = false, names = false;
};

std::string text(const char* format, auto... values) {
  char line[400];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

void write_compliance(const fs::path& folder) {
  const Model model = load_model(folder / "model.toml");
  const Compliance compliance = precompute(model, {Backend::sparse}, &terminal_progress());
  save_compliance(folder / "C.h5", compliance, model, false, &terminal_progress());
}

/// An earlier patient.toml may hold a day's work by hand.
void keep_edited(const fs::path& folder) {
  if (!fs::exists(folder / "patient.toml")) return;
  std::error_code code;
  fs::copy_file(folder / "patient.toml", folder / "patient.toml.old", fs::copy_options::overwrite_existing, code);
  if (code) throw FailedError((folder / "patient.toml.old").string(), "can't be written: " + code.message());
  say("the earlier patient.toml is kept as patient.toml.old");
}

/// What an earlier patient in this folder had and this one hasn't would belong to nobody.
void remove_stale(const fs::path& folder, const std::vector<std::string>& files) {
  std::vector<std::string> stale{"C.h5"};
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder / "surfaces", code))
    if (entry.path().extension() == ".ply") stale.push_back("surfaces/" + entry.path().filename().string());
  for (const std::string& file : stale)
    if (std::find(files.begin(), files.end(), file) == files.end()) fs::remove(folder / file, code);
}

void write_folder(const PatientArguments& arguments, const MadePatient& made, StagedFolder& folder) {
  std::vector<std::string> files = patient_files(made.patient);
  files.insert(files.begin(), "preview.png");
  if (arguments.compliance) files.insert(files.begin(), "C.h5");
  std::vector<fs::path> inputs = arguments.request.centrelines;
  inputs.insert(inputs.end(), {arguments.request.ct, arguments.request.labels, arguments.request.table});
  folder.require_apart(files, inputs);
  keep_edited(folder.target());
  folder.fill(
      [&](const fs::path& place) {
        terminal_progress().phase("writing");
        write_patient(place, made.patient, made.meshed, made.anatomy, made.provenance);
        terminal_progress().at(0.5);
        write_png(place / "preview.png", patient_preview(made.patient, made.anatomy));
        terminal_progress().at(1);
        if (arguments.compliance) write_compliance(place);
      },
      files);
  remove_stale(folder.target(), files);
}

void make(const PatientArguments& arguments) {
  Stopwatch watch;
  StagedFolder folder(arguments.folder);
  folder.require_own("patient.toml");
  PatientRequest request = arguments.request;
  if (request.name.empty()) request.name = folder.target().filename().string();
  if (arguments.overlap == "smaller") request.overlaps = OverlapRule::smaller;
  request.surface_unit = metres_per(arguments.surface_unit, "--surface-unit");
  if (std::any_of(request.name.begin(), request.name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }) ||
      request.name.find_first_not_of(' ') == std::string::npos)
    throw InputError("--name", "the patient's name is empty or has control characters", "give a line of text");
  folder.open();  // says at once if it can't be made
  MadePatient made = make_patient(request, {say, warn}, terminal_progress());
  made.provenance.versions["calot"] = CALOT_VERSION;
  write_folder(arguments, made, folder);
  say("wrote " + (arguments.folder / "patient.toml").string() + " in " + seconds_text(watch.lap()) + ", " +
      readable_bytes(peak_memory()) + " at most; look at " + (arguments.folder / "preview.png").string());
}

/// The compliance is of no use to the patient room, so it is looked at here.
std::vector<Finding> check_compliance(const fs::path& folder) {
  if (!fs::exists(folder / "C.h5")) return {};
  try {
    (void)load_compliance(folder / "C.h5", load_model(folder / "model.toml"));
  } catch (const Error& error) {
    return {{true, "C.h5", error.what(), "make it again: calot precompute model.toml -o C.h5 --backend sparse"}};
  }
  return {};
}

/// Prints every finding; errors end with exit code 2.
void run_check(const fs::path& folder) {
  std::size_t errors = 0, warnings = 0;
  std::vector<Finding> findings = check_patient(folder);
  for (const Finding& finding : check_compliance(folder)) findings.push_back(finding);
  for (const Finding& finding : findings) {
    ++(finding.error ? errors : warnings);
    say(std::string(finding.error ? "error: " : "warning: ") + finding.where + ": " + finding.what +
        (finding.what_to_do.empty() ? "" : "; " + finding.what_to_do));
  }
  if (errors > 0)
    throw InputError(folder.string(), text("%zu thing%s wrong, see above", errors, errors == 1 ? " is" : "s are"),
                     "mend them, or make the folder again with calot patient");
  say(folder.string() + ": sound" + (warnings > 0 ? text(", %zu warning%s", warnings, warnings == 1 ? "" : "s") : ""));
}

void print_names() {
  for (const auto& [name, structure] : NameTable::built_in().names)
    say(text("%-36s %s", name.c_str(), std::string(name_of(structure)).c_str()));
}

void run_patient(const PatientArguments& arguments) {
  if (arguments.names) return print_names();
  if (!arguments.check.empty()) return run_check(arguments.check);
  if (!arguments.write_table.empty()) {
    if (fs::exists(arguments.write_table))
      throw InputError(arguments.write_table.string(), "exists already", "name another file, or remove it first");
    write_file(arguments.write_table, [](std::ostream& out) { write_import_options(out, ImportOptions{}); });
    return say("wrote " + arguments.write_table.string() + "; change it and give it with --table");
  }
  if (arguments.request.ct.empty() || arguments.request.labels.empty() || arguments.folder.empty())
    throw InputError("patient", "needs CT, LABELS and -o DIR (or --check DIR)", "see calot patient --help");
  make(arguments);
}

void add_options(CLI::App& command, PatientArguments& arguments) {
  CLI::Option* const ct = command.add_option("CT", arguments.request.ct, "CT: a DICOM folder, .nii, .nii.gz or .nrrd");
  command.add_option("LABELS", arguments.request.labels,
                     "segmentation: .nii, .nii.gz, .nrrd, .seg.nrrd, a folder of masks, or surfaces (.stl .obj .ply)");
  command.add_option("-o,--output", arguments.folder, "the patient's folder")->type_name("DIR");
  command
      .add_option("--ducts", arguments.request.centrelines,
                  "centrelines with radii of ducts and arteries (.mrk.json, .txt, .csv)")
      ->type_name("FILE")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--table", arguments.request.table, "labels.toml: what names and numbers mean, and all thresholds")
      ->type_name("FILE");
  command.add_option("--tets", arguments.request.tets, "how many tetrahedra at most")
      ->check(CLI::Range(4000, 2000000))
      ->capture_default_str();
  command.add_option("--name", arguments.request.name, "the patient's name in patient.toml; default: the folder's");
  command.add_option("--series", arguments.request.series,
                     "which DICOM series, where there are several: its UID or number");
  command.add_option("--overlap", arguments.overlap, "structures that share voxels: refuse, or the smaller keeps them")
      ->check(CLI::IsMember({"refuse", "smaller"}))
      ->capture_default_str();
  command.add_flag("--resample-labels", arguments.request.resample_labels, "put labels of another grid onto the CT's");
  command.add_option("--surface-unit", arguments.surface_unit, "of surfaces given as LABELS")
      ->check(CLI::IsMember({"mm", "cm", "m"}))
      ->capture_default_str();
  command.add_flag("--compliance", arguments.compliance, "precompute C.h5 (sparse) as well");
  command.add_option("--check", arguments.check, "only check a patient's folder")->type_name("DIR")->excludes(ct);
  command.add_flag("--names", arguments.names, "only list the names that are understood");
  command.add_option("--write-table", arguments.write_table, "only write a labels.toml with every default, to change")
      ->type_name("FILE");
}

}  // namespace

void add_patient_command(CLI::App& app) {
  auto arguments = std::make_shared<PatientArguments>();
  CLI::App* command = app.add_subcommand("patient", "Make a patient's folder from CT and labels, or check one");
  add_options(*command, *arguments);
  command->footer(
      "Examples:\n"
      "  calot patient ct.nii.gz labels.nii.gz --ducts ducts.mrk.json -o anna\n"
      "  calot patient dicom_folder totalsegmentator_output --ducts ducts.txt -o anna\n"
      "  calot patient --check anna");
  command->callback([arguments] { run_patient(*arguments); });
}

}  // namespace calot
