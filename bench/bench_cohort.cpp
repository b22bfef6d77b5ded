// Twenty patients and every anatomical variant, from CT files to a checked folder.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "bench/benchmarks.h"
#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/patient/make_patient.h"
#include "calot/patient/phantom.h"

namespace calot::bench {
namespace {

namespace fs = std::filesystem;

struct Member {
  PhantomOptions phantom = {};
  PhantomFacts facts = {};
  std::string failure = {};              ///< empty: went through
  std::size_t errors = 0, warnings = 0;  ///< of the check
  double seconds = 0, peak_volume_error = 0, duct_volume_error = 0;
  double liver_ml = 0, gallbladder_ml = 0, fat_ml = 0, duct_ml = 0;  ///< of the mesh
  Quality quality = {};
  bool manifold = false;
};

/// A folder that goes when it is left.
class Scratch {
 public:
  Scratch() : path_(fs::temp_directory_path() / ("calot-cohort-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void write_inputs(const fs::path& folder, Member& member, Progress& progress) {
  const Phantom phantom = make_phantom(member.phantom, progress);
  write_ct(folder / "ct.nii.gz", phantom.ct);
  write_label_map(folder / "labels.nii.gz", phantom.labels);
  write_markups(folder / "ducts.mrk.json", phantom.lines);
  member.facts = phantom.facts;
}

void note_volumes(const LabelMesh& meshed, Member& member) {
  for (const MeshedRegion& region : meshed.regions) {
    const double error = region.quality.volume / region.voxel_volume - 1, ml = region.quality.volume * 1e6;
    if (std::abs(error) > std::abs(member.peak_volume_error)) member.peak_volume_error = error;
    switch (static_cast<Structure>(region.label)) {
      case Structure::liver:
        member.liver_ml = ml;
        break;
      case Structure::gallbladder:
        member.gallbladder_ml = ml;
        break;
      case Structure::hepatocystic_fat:
        member.fat_ml = ml;
        break;
      case Structure::cystic_duct:
        member.duct_ml = ml;
        member.duct_volume_error = error;
        break;
      default:
        break;
    }
  }
  member.quality = meshed.quality;
  member.manifold = meshed.outer.closed_manifold();
}

void go_through(const fs::path& folder, Member& member, Progress& progress) {
  write_inputs(folder, member, progress);
  PatientRequest request;
  request.ct = folder / "ct.nii.gz";
  request.labels = folder / "labels.nii.gz";
  request.centrelines = {folder / "ducts.mrk.json"};
  request.name = "seed " + std::to_string(member.phantom.seed);
  const Stopwatch watch;
  const MadePatient made = make_patient(request, {}, progress);
  const fs::path place = folder / "patient";
  fs::remove_all(place);
  fs::create_directories(place);
  write_patient(place, made.patient, made.meshed, made.anatomy, made.provenance);
  member.seconds = watch.seconds();
  note_volumes(made.meshed, member);
  for (const Finding& finding : check_patient(place)) ++(finding.error ? member.errors : member.warnings);
}

std::string line_of(const Member& m) {
  char line[400];
  if (!m.failure.empty())
    std::snprintf(line, sizeof line, "| %llu | %s | failed: %.200s | | | | | | | | |",
                  static_cast<unsigned long long>(m.phantom.seed), name_of(m.phantom.variant).data(),
                  m.failure.c_str());
  else
    std::snprintf(
        line, sizeof line,
        "| %llu | %s | %.0f | %.1f | %.2f | %.1f | %.3f | %+.1f | %+.1f | %zu | %.1f-%.1f | %s | %zu/%zu | %.0f |",
        static_cast<unsigned long long>(m.phantom.seed), name_of(m.phantom.variant).data(), m.liver_ml,
        m.gallbladder_ml, 1e3 * m.facts.cystic_duct_length, m.fat_ml, m.duct_ml, 100 * m.duct_volume_error,
        100 * m.peak_volume_error, m.quality.tets, m.quality.min_dihedral, m.quality.max_dihedral,
        m.manifold ? "yes" : "NO", m.errors, m.warnings, m.seconds);
  return line;
}

void write_table(const fs::path& path, std::span<const Member> members) {
  write_file(path, [&](std::ostream& out) {
    out << "| seed | variant | liver mL | gallbladder mL | duct mm | fat mL | duct mL | duct volume off % | worst "
           "volume "
           "off % | tets | angles | manifold | errors/warnings of the check | s |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const Member& member : members) out << line_of(member) << '\n';
  });
}

/// Everybody: twenty usual ones, then one of each variant.
std::vector<Member> cohort() {
  std::vector<Member> members;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) members.push_back({.phantom = {.seed = seed}});
  for (const auto variant :
       {PhantomVariant::short_cystic_duct, PhantomVariant::low_insertion, PhantomVariant::aberrant_right_duct,
        PhantomVariant::second_cystic_artery, PhantomVariant::inflamed})
    members.push_back({.phantom = {.seed = members.size() + 1, .variant = variant}});
  return members;
}

}  // namespace

std::vector<Row> bench_cohort(const BenchOptions& options) {
  Progress silent;
  Progress& progress = options.progress ? *options.progress : silent;
  const Scratch scratch;
  std::vector<Member> members = cohort();
  double failed = 0, errors = 0, worst_duct = 0, worst = 0, flattest = 180, widest = 0, most_tets = 0;
  std::vector<double> seconds;
  std::size_t done = 0;
  for (Member& member : members) {
    try {
      go_through(scratch.path(), member, progress);
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& error) {
      member.failure = error.what();
    }
    failed += member.failure.empty() ? 0 : 1;
    errors += static_cast<double>(member.errors);
    ++done;
    if (!options.output.empty()) write_table(options.output / "cohort.md", std::span(members).first(done));
    if (!member.failure.empty()) continue;
    worst_duct = std::max(worst_duct, std::abs(member.duct_volume_error));
    worst = std::max(worst, std::abs(member.peak_volume_error));
    flattest = std::min(flattest, member.quality.min_dihedral);
    widest = std::max(widest, member.quality.max_dihedral);
    most_tets = std::max(most_tets, static_cast<double>(member.quality.tets));
    seconds.push_back(member.seconds);
  }
  std::vector<Row> rows;
  rows.push_back({.name = "cohort.failed", .value = failed, .unit = "patients", .goal = 0});
  rows.push_back({.name = "cohort.check_errors", .value = errors, .unit = "errors", .goal = 0});
  rows.push_back({.name = "cohort.duct_volume_error", .value = 100 * worst_duct, .unit = "%", .goal = 5});
  rows.push_back({.name = "cohort.volume_error", .value = 100 * worst, .unit = "%", .goal = 5});
  // As shortfalls, so that lower is better.
  rows.push_back({.name = "cohort.min_dihedral_below_60", .value = 60 - flattest, .unit = "deg", .goal = 50});
  rows.push_back({.name = "cohort.max_dihedral", .value = widest, .unit = "deg", .goal = 165});
  rows.push_back({.name = "cohort.tets", .value = most_tets, .unit = "tets", .goal = 20000});
  if (!seconds.empty()) rows.push_back(distribution_row("cohort.patient", "s", seconds));
  return rows;
}

}  // namespace calot::bench
