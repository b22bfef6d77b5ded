// Example 3: a model without files. A cantilever of soft tissue, held at one end, loaded at the other.
#include <calot/calot.h>

#include <iostream>

#include "sample_model.h"

using namespace calot;

int main() try {
  // Any mesh will do: positions, tets (positively oriented), a region number on each tet.
  TetMesh mesh = sample::organ();

  // Materials by region, supports by vertex, and how time advances. A time step of 0 means statics.
  const std::map<std::int32_t, Material> materials{{2, {.young = 20e3, .poisson = 0.45, .density = 1060}},
                                                   {3, {.young = 500e3, .poisson = 0.45, .density = 1060}},
                                                   {4, {.young = 500e3, .poisson = 0.45, .density = 1060}}};
  std::vector<std::uint8_t> fixed(mesh.vertex_count());
  for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = mesh.positions[v].x() < -0.005 ? 1 : 0;
  const Model model(std::move(mesh), materials, fixed, Dynamics{.time_step = 0});

  // The weight of the tissue itself: gravity times each vertex's mass.
  const Compliance compliance = precompute(model);
  const std::vector<double> masses = model.vertex_masses();
  std::vector<PointForce> weight;
  for (std::size_t v = 0; v < masses.size(); ++v) weight.push_back({VertexId(v), {0, 0, -9.81 * masses[v]}});
  const Displacements u = compliance.solve(weight);

  double lowest = 0, total = 0;
  for (const Vec3& displacement : u) lowest = std::min(lowest, displacement.z());
  for (const double mass : masses) total += mass;
  std::cout << "it weighs " << 1e3 * total << " g and sags by " << -1e3 * lowest << " mm\n";

  // Results go to ParaView, 3D Slicer and others as .vtu.
  VertexArray displacement{"displacement", 3, {}};
  for (const Vec3& d : u) displacement.values.insert(displacement.values.end(), d.begin(), d.end());
  const auto file = std::filesystem::temp_directory_path() / "calot_example_sag.vtu";
  write_mesh(file, model.mesh(), {displacement});
  std::cout << "see " << file.string() << '\n';
  return lowest < -1e-5 && std::filesystem::file_size(file) > 0 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << '\n';
  return error.exit_code();
}
