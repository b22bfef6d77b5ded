// A patient that can be operated on, and the folder that holds one.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "calot/mesh/quality.h"
#include "calot/mesh/tet_mesh.h"
#include "calot/patient/attachments.h"
#include "calot/patient/landmarks.h"
#include "calot/patient/materials.h"
#include "calot/patient/mesher.h"

namespace calot {

struct Patient {
  std::string name;
  TetMesh mesh;                                   ///< RAS [m]; region = Structure number
  std::map<Structure, TissueMaterial> materials;  ///< of every region of the mesh
  std::map<Structure, Appearance> appearances;    ///< the same
  std::vector<Attachment> attachments;
  std::vector<Centreline> lines;  ///< of the tubes
  Landmarks landmarks;
  std::vector<BorderCut> border_cuts;
};

/// Where the files of a folder come from, for provenance.json.
struct Provenance {
  struct Input {
    std::string role, path, sha256;  ///< "CT", "labels", "centrelines", "labels.toml"; the file's name without folders
  };
  std::vector<Input> inputs;
  std::map<std::string, std::string> versions;    ///< "calot", "CGAL", "ITK" …
  std::map<std::string, std::string> parameters;  ///< every option that shaped the result, as text
  std::vector<CompletionStep> steps;
};

/// The files that `write_patient` writes, patient.toml last: surfaces too.
std::vector<std::string> patient_files(const Patient& patient);

/// Writes a patient's folder (which exists): patient.toml (documented, units stated, RAS mm), model.toml, mesh.msh,
/// mesh.vtu, surfaces/NAME.ply (normals and triplanar weights), centrelines.mrk.json, labels.nii.gz, quality.json,
/// provenance.json. Each file whole or not at all; the same patient gives the same bytes.
void write_patient(const std::filesystem::path& folder, const Patient& patient, const LabelMesh& meshed,
                   const CompletedAnatomy& anatomy, const Provenance& provenance);

/// Reads patient.toml with the mesh it names. Throws InputError naming file and line: what doesn't parse, unknown keys,
/// materials out of range, vertices and regions that the mesh doesn't have, landmarks that aren't finite.
Patient load_patient(const std::filesystem::path& folder);

/// What is wrong with a patient's folder, in words a user can act on; empty when nothing is.
struct Finding {
  bool error = true;  ///< false: a warning
  std::string where;  ///< file or landmark
  std::string what, what_to_do;
};

/// Checks a folder: files there and whole (hashes of provenance.json, the mesh against quality.json), the mesh sound
/// (validate, manifold outside, one part a region, angles), materials in range, every part held, landmarks that make
/// sense (clips in order with the cut between, on their tube; ports outside of every organ and apart from each other;
/// the camera sees the triangle; …). Throws nothing but for a folder that isn't there.
std::vector<Finding> check_patient(const std::filesystem::path& folder);

}  // namespace calot
