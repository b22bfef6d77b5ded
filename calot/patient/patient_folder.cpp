#include <cmath>
#include <ostream>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/mesh/mesh_file.h"
#include "calot/patient/centreline_file.h"
#include "calot/patient/patient_file.h"
#include "calot/patient/quality_json.h"
#include "calot/patient/surface_file.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

using detail::Json;

Json step_json(const CompletionStep& step) {
  return {{"step", step.step},          {"structure", std::string(name_of(step.structure))},
          {"voxels_added", step.added}, {"voxels_removed", step.removed},
          {"added_ml", step.added_ml},  {"removed_ml", step.removed_ml},
          {"detail", step.detail}};
}

std::string made_by(const Provenance& provenance) {
  const auto version = provenance.versions.find("calot");
  return version == provenance.versions.end() ? "calot" : "calot " + version->second;
}

/// Hand-edited files have no hash: patient.toml and model.toml are meant to be changed.
Json provenance_json(const fs::path& folder, const std::vector<std::string>& hashed, const CompletedAnatomy& anatomy,
                     const Provenance& provenance) {
  Json json{{"made_by", made_by(provenance)}, {"inputs", Json::array()}};
  for (const Provenance::Input& input : provenance.inputs)
    json["inputs"].push_back({{"role", input.role}, {"file", input.path}, {"sha256", input.sha256}});
  json["versions"] = provenance.versions;
  json["parameters"] = provenance.parameters;
  json["steps"] = Json::array();
  for (const CompletionStep& step : provenance.steps) json["steps"].push_back(step_json(step));
  json["warnings"] = anatomy.warnings;
  json["files"] = Json::object();
  for (const std::string& name : hashed) json["files"][name] = sha256_of_file(folder / name);
  return json;
}

TetMesh in_mm(const TetMesh& mesh) {
  TetMesh scaled = mesh;
  for (Vec3& p : scaled.positions) p *= 1e3;
  return scaled;
}

void write_surfaces(const fs::path& folder, const Patient& patient) {
  std::error_code code;
  fs::create_directory(folder / "surfaces", code);
  if (code) throw FailedError((folder / "surfaces").string(), "can't be made: " + code.message());
  for (const auto& [structure, material] : patient.materials) {
    const auto look = patient.appearances.find(structure);
    const double sharpness = look == patient.appearances.end() ? 4 : look->second.blend_sharpness;
    detail::write_textured_surface(folder / detail::surface_name(structure),
                                   textured_surface(patient.mesh, label_of(structure), sharpness));
  }
}

}  // namespace

std::vector<std::string> patient_files(const Patient& patient) {
  std::vector<std::string> files{"mesh.msh", "mesh.vtu"};
  for (const auto& [structure, material] : patient.materials) files.push_back(detail::surface_name(structure));
  if (!patient.lines.empty()) files.emplace_back("centrelines.mrk.json");
  files.insert(files.end(), {"labels.nii.gz", "quality.json", "provenance.json", "model.toml", "patient.toml"});
  return files;
}

void write_patient(const fs::path& folder, const Patient& patient, const LabelMesh& meshed,
                   const CompletedAnatomy& anatomy, const Provenance& provenance) {
  const TetMesh scaled = in_mm(patient.mesh);
  write_mesh(folder / "mesh.msh", scaled);
  write_mesh(folder / "mesh.vtu", scaled);
  write_surfaces(folder, patient);
  if (!patient.lines.empty()) write_markups(folder / "centrelines.mrk.json", patient.lines);
  write_label_map(folder / "labels.nii.gz", anatomy.labels);
  const auto write_text = [&](const std::string& name, const std::string& text) {
    write_file(folder / name, [&](std::ostream& out) { out << text; });
  };
  write_text("quality.json", detail::json_text(detail::mesh_report(meshed, patient.name)));
  std::vector<std::string> hashed = patient_files(patient);
  hashed.resize(hashed.size() - 3);  // all before provenance.json itself, model.toml and patient.toml
  write_text("provenance.json", detail::json_text(provenance_json(folder, hashed, anatomy, provenance)));
  write_file(folder / "model.toml",
             [&](std::ostream& out) { detail::write_model_toml(out, patient, made_by(provenance)); });
  write_file(folder / "patient.toml",
             [&](std::ostream& out) { detail::write_patient_toml(out, patient, made_by(provenance)); });
}

}  // namespace calot
