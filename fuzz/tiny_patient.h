// A patient of four cubes, for the fuzzer of patient.toml and its seed.
#pragma once
#include <filesystem>
#include <sstream>

#include "calot/mesh/mesh_file.h"
#include "calot/patient/centreline_file.h"
#include "calot/patient/patient_file.h"
#include "tests/support/meshes.h"

namespace calot::fuzz {

inline Patient tiny_patient() {
  Patient patient;
  patient.name = "tiny";
  patient.mesh = test::cell_mesh(4, 1, 1, {0.02, 0.005, 0.005}, [](int i, int, int) { return i + 1; });
  for (const Structure s :
       {Structure::liver, Structure::gallbladder, Structure::cystic_duct, Structure::common_bile_duct}) {
    patient.mesh.region_names[label_of(s)] = std::string(name_of(s));
    patient.materials[s] = material_of(s);
    patient.appearances[s] = appearance_of(s);
  }
  patient.lines = {{"cystic duct", {{0.015, 0.0025, 0.0025}, {0.010, 0.0025, 0.0025}}, {2e-3, 2e-3}}};
  patient.attachments = {{"end", AttachmentKind::fixed, {VertexId(4), VertexId(9), VertexId(14)}, "the CT ends"},
                         {"skin", AttachmentKind::peritoneum, {VertexId(1), VertexId(6)}, "covers both"}};
  patient.border_cuts = {{Structure::liver, 0, false, {0, 0, 0}, {-1, 0, 0}, 25e-6}};
  patient.landmarks.triangle = {{0.015, 0, 0}, {0.010, 0.005, 0}, {0.012, 0, 0.005}};
  patient.landmarks.ports = {{"camera", {0.0, 0.15, -0.05}, 10e-3, "laparoscope"},
                             {"epigastric", {0.05, 0.15, 0}, 5e-3, "dissector"}};
  patient.landmarks.camera = {{0.01, 0.08, -0.02}, {0.012, 0, 0}, {0, 0, 1}, 30, 70};
  for (const double arc : {0.5e-3, 1.5e-3, 4e-3}) {
    const LinePlace place = place_at(patient.lines[0], arc);
    patient.landmarks.clips.push_back(
        {"clip", Structure::cystic_duct, arc, place.point, place.direction, place.radius});
  }
  patient.landmarks.cuts = {{"cut", Structure::cystic_duct, 3e-3, {0.012, 0.0025, 0.0025}, {-1, 0, 0}, 2e-3}};
  patient.landmarks.notes = {"tiny"};
  return patient;
}

inline std::string tiny_patient_toml() {
  std::ostringstream out;
  detail::write_patient_toml(out, tiny_patient(), "calot");
  return out.str();
}

/// What patient.toml names, in part: mesh, centrelines and model.
inline void write_named_files(const std::filesystem::path& folder, const Patient& patient) {
  TetMesh mesh = patient.mesh;
  for (Vec3& p : mesh.positions) p *= 1e3;
  write_mesh(folder / "mesh.msh", mesh);
  write_markups(folder / "centrelines.mrk.json", patient.lines);
  std::ofstream model(folder / "model.toml");
  detail::write_model_toml(model, patient, "calot");
}

inline void write_tiny_files(const std::filesystem::path& folder) {
  write_named_files(folder, tiny_patient());
}

}  // namespace calot::fuzz
