// A small organ for the examples: writes sample.msh and model.toml into a folder of its own and says where.
#pragma once
#include <calot/calot.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace sample {

/// Cells of 4 mm, each split into six tets: a gallbladder (region 2), a cystic duct along x from x = 0 to 20 mm (region
/// 3) and a common bile duct along z (region 4). Metres.
inline calot::TetMesh organ() {
  using namespace calot;
  TetMesh mesh;
  std::map<std::vector<int>, VertexId> vertex_at;
  const auto vertex = [&](int i, int j, int k) {
    const auto [place, is_new] = vertex_at.try_emplace({i, j, k}, VertexId(mesh.positions.size()));
    if (is_new) mesh.positions.push_back(0.004 * Vec3(i, j, k));
    return place->second;
  };
  const auto fill = [&](int region, std::vector<int> low, std::vector<int> high) {
    for (int k = low[2]; k < high[2]; ++k)
      for (int j = low[1]; j < high[1]; ++j)
        for (int i = low[0]; i < high[0]; ++i) {
          VertexId c[8];
          for (int n = 0; n < 8; ++n) c[n] = vertex(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2));
          for (const auto& [p, q] : {std::pair{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}) {
            mesh.tets.push_back({c[0], c[p], c[q], c[7]});
            mesh.regions.push_back(region);
          }
        }
  };
  fill(2, {5, -3, -4}, {12, 3, 4});
  fill(3, {0, -1, -1}, {5, 1, 1});
  fill(4, {-2, -1, -6}, {0, 1, 6});
  mesh.region_names = {{2, "gallbladder"}, {3, "cystic duct"}, {4, "common bile duct"}};
  return mesh;
}

/// @return the path of model.toml
inline std::filesystem::path model_file() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "calot_example";
  std::filesystem::create_directories(folder);
  calot::write_mesh(folder / "sample.msh", organ());
  std::ofstream(folder / "model.toml") << R"(mesh = "sample.msh"
length_unit = "m"
time_step = 0.02
[[material]]
region = "*"
young = 1.0e6
poisson = 0.45
density = 1000.0
[[fixed]]                     # both ends of the common bile duct
box = { min = [-1, -1, -1], max = [1, 1, -0.0239] }
[[fixed]]
box = { min = [-1, -1, 0.0239], max = [1, 1, 1] }
)";
  return folder / "model.toml";
}

}  // namespace sample
