// A meshed label map as a folder that the other commands take: mesh, surfaces, model.toml, quality.json.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calot/patient/mesher.h"

namespace calot {

/// Where the model is held, and why; chosen from the anatomy, to be changed by hand in model.toml.
struct Support {
  std::string reason;                      ///< a comment for model.toml
  std::vector<Eigen::AlignedBox3d> boxes;  ///< [m]; their vertices are fixed …
  std::vector<std::string> box_reasons;    ///< one a box
  std::vector<VertexId> vertices;          ///< … and these
};

/// Chooses the supports:
/// - with a region named "common bile duct": its two ends;
/// - with several regions else: the outer vertices of the largest one that lie farther than 30 mm from all others (less
/// where
///   it is small), as a liver is held far from the gallbladder;
/// - with one region: its upper end, the topmost tenth.
Support choose_support(const LabelMesh& meshed);

/// The names of the files that `write_label_mesh` writes, model.toml last: mesh.msh, mesh.vtu, an .stl a region,
/// quality.json.
std::vector<std::string> label_mesh_files(const LabelMesh& meshed);

/// Writes the mesh and the surfaces (mm), quality.json and model.toml into a folder that exists; each file whole or not
/// at all.
/// @param source  what was meshed, for the comments: a file's name
void write_label_mesh(const std::filesystem::path& folder, const LabelMesh& meshed, const std::string& source);

/// A region's name made fit for a file name: "common_bile_duct"; "region_7" without one.
std::string file_name_of(const MeshedRegion& region);

}  // namespace calot
