#include "calot/patient/make_patient.h"

#include <array>
#include <cstdio>
#include <sstream>

#include "calot/base/files.h"
#include "calot/image/ct_file.h"
#include "calot/patient/centreline_file.h"
#include "calot/patient/field_mesh.h"

namespace calot {
namespace {

namespace fs = std::filesystem;

std::string text(const char* format, auto... values) {
  std::array<char, 400> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

/// Reads, completes, meshes: what each step of `calot patient` hands to the next.
class PatientMaker {
 public:
  PatientMaker(const PatientRequest& request, const PatientLog& log, Progress& progress)
      : request_(request), log_(log), progress_(progress) {
    if (request.table.empty()) return;
    options_ = read_import_options(request.table);
    add_input("labels.toml", request.table);
  }
  MadePatient make();

 private:
  void read_images();
  void read_labels(const VoxelGrid& grid);
  void say_segments(const Segmentation& segmentation);
  void read_lines();
  void complete();
  void say_step(const CompletionStep& step);
  void mesh();
  void find_field();
  void note_parameters();
  void add_input(const std::string& role, const fs::path& path) {
    made_.provenance.inputs.push_back({role, path.filename().string(), sha256_of_file(path)});
  }
  void say(const std::string& line) { log_.say(line); }
  void warn_all(const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) log_.warn(warning);
  }

  const PatientRequest& request_;
  const PatientLog& log_;
  Progress& progress_;
  ImportOptions options_;
  CtFile ct_;
  StructureLabels labels_;
  std::vector<Centreline> lines_;
  MadePatient made_;
  std::string last_detail_;  // said already
};

void PatientMaker::read_images() {
  ct_ = read_ct(request_.ct, progress_, request_.series);
  const auto& size = ct_.ct.grid.size;
  const Vec3 spacing = 1e3 * ct_.ct.grid.spacing();
  say(text("CT: %s, %zu x %zu x %zu voxels of %.3g x %.3g x %.3g mm", ct_.format.c_str(), size[0], size[1], size[2],
           spacing[0], spacing[1], spacing[2]));
  for (const std::string& note : ct_.notes) say("  " + note);
  for (const std::string& file : ct_.inputs) add_input("CT", file);
  read_labels(ct_.ct.grid);
}

void PatientMaker::read_labels(const VoxelGrid& grid) {
  SegmentationOptions reading;
  reading.reference = grid;
  reading.resample = request_.resample_labels;
  reading.surface_unit = request_.surface_unit;
  reading.wanted = [&](const std::string& name) {
    return options_.table.find(name).value_or(Structure::none) != Structure::none;
  };
  const Segmentation segmentation = read_segmentation(request_.labels, reading, progress_);
  for (const std::string& file : segmentation.inputs) add_input("labels", file);
  labels_ = label_structures(segmentation, options_.table, request_.overlaps, request_.labels.string());
  say_segments(segmentation);
}

void PatientMaker::say_segments(const Segmentation& segmentation) {
  say("labels: " + segmentation.format);
  std::string left_out;
  for (const TakenSegment& segment : labels_.segments)
    if (segment.structure != Structure::none)
      say(text("  %-28s %10zu voxels %9.2f mL  is the %s", segment.name.c_str(), segment.voxels, segment.ml,
               std::string(name_of(segment.structure)).c_str()));
    else
      left_out += (left_out.empty() ? "" : ", ") + segment.name;
  for (const std::string& name : segmentation.unread) left_out += (left_out.empty() ? "" : ", ") + name;
  if (!left_out.empty()) say("  left out: " + left_out);
  for (const std::string& note : segmentation.notes) say("  " + note);
  warn_all(labels_.warnings);
}

void PatientMaker::read_lines() {
  for (const fs::path& path : request_.centrelines) {
    for (Centreline& line : read_centrelines(path)) {
      say(text("centreline: %s, %zu points, %.1f mm", line.name.c_str(), line.points.size(), 1e3 * length(line)));
      lines_.push_back(std::move(line));
    }
    add_input("centrelines", path);
  }
}

void PatientMaker::say_step(const CompletionStep& step) {
  std::string line = "  " + step.step;
  if (step.structure != Structure::none) line += ", " + std::string(name_of(step.structure));
  if (step.added > 0) line += text(": +%zu voxels (%.3g mL)", step.added, step.added_ml);
  if (step.removed > 0)
    line += text("%s -%zu voxels (%.3g mL)", step.added > 0 ? "," : ":", step.removed, step.removed_ml);
  if (!step.detail.empty() && step.detail != last_detail_) line += " [" + step.detail + "]";
  last_detail_ = step.detail;
  say(line);
}

void PatientMaker::complete() {
  made_.anatomy = complete_anatomy(ct_.ct, labels_.labels, lines_, options_.completion, progress_);
  ct_ = {};
  labels_ = {};
  say("completed:");
  for (const CompletionStep& step : made_.anatomy.steps) say_step(step);
  warn_all(made_.anatomy.warnings);
  made_.provenance.steps = made_.anatomy.steps;
}

void PatientMaker::mesh() {
  made_.meshed = mesh_labels(made_.anatomy.labels, field_mesh_options(made_.anatomy.labels, request_.tets), progress_);
  say(text("mesh: %zu vertices, %zu tetrahedra, angles %.1f to %.1f degrees, outside %s", made_.meshed.quality.vertices,
           made_.meshed.quality.tets, made_.meshed.quality.min_dihedral, made_.meshed.quality.max_dihedral,
           made_.meshed.outer.closed_manifold() ? "closed and manifold" : "NOT a closed manifold"));
  say(text("  %-28s %8s %9s %7s %7s %10s %10s %8s", "region", "tets", "edge mm", "angle", "to deg", "voxels mL",
           "mesh mL", "volume"));
  for (const MeshedRegion& region : made_.meshed.regions) {
    const Quality& q = region.quality;
    say(text("  %-28s %8zu %9.2f %7.1f %7.1f %10.3f %10.3f %+7.2f%%", region.name.c_str(), q.tets, q.mean_edge * 1e3,
             q.min_dihedral, q.max_dihedral, region.voxel_volume * 1e6, q.volume * 1e6,
             100 * (q.volume / region.voxel_volume - 1)));
  }
  for (const std::string& note : made_.meshed.notes) say("  " + note);
}

void PatientMaker::find_field() {
  made_.patient.name = request_.name;
  made_.patient.mesh = made_.meshed.mesh;
  for (const MeshedRegion& region : made_.meshed.regions) {
    const auto structure = static_cast<Structure>(region.label);
    made_.patient.materials[structure] = material_of(structure);
    made_.patient.appearances[structure] = appearance_of(structure);
  }
  made_.patient.attachments = find_attachments(made_.meshed.mesh, made_.anatomy);
  made_.patient.lines = made_.anatomy.lines;
  made_.patient.landmarks = find_landmarks(made_.anatomy);
  made_.patient.border_cuts = made_.anatomy.border_cuts;
  for (const Attachment& a : made_.patient.attachments)
    say(text("held: %s, %zu vertices (%s)", a.name.c_str(), a.vertices.size(),
             a.kind == AttachmentKind::fixed ? "fixed" : "peritoneum"));
  for (const std::string& note : made_.patient.landmarks.notes) say("landmarks: " + note);
}

void PatientMaker::note_parameters() {
  for (const auto& [library, version] : mesher_versions()) made_.provenance.versions[library] = version;
  made_.provenance.parameters["tets"] = std::to_string(request_.tets);
  made_.provenance.parameters["overlap"] = request_.overlaps == OverlapRule::smaller ? "smaller" : "refuse";
  made_.provenance.parameters["resample_labels"] = request_.resample_labels ? "yes" : "no";
  if (!request_.series.empty()) made_.provenance.parameters["series"] = request_.series;
  std::ostringstream table;
  write_import_options(table, options_);
  made_.provenance.parameters["labels.toml"] = table.str();
}

MadePatient PatientMaker::make() {
  read_images();
  read_lines();
  complete();
  mesh();
  find_field();
  note_parameters();
  return std::move(made_);
}

}  // namespace

MadePatient make_patient(const PatientRequest& request, const PatientLog& log, Progress& progress) {
  return PatientMaker(request, log, progress).make();
}

}  // namespace calot
