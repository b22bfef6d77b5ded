// Models on generated meshes.
#pragma once
#include "calot/fem/model.h"
#include "tests/support/meshes.h"

namespace calot::test {

/// One material everywhere; vertices where `held` is true are fixed.
template <class Held>
Model make_model(TetMesh mesh, double time_step, const Held& held, Material material = {}, Dynamics dynamics = {}) {
  std::vector<std::uint8_t> fixed(mesh.vertex_count());
  for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = held(mesh.positions[v]) ? 1 : 0;
  std::map<std::int32_t, Material> materials;
  for (const std::int32_t region : mesh.regions) materials[region] = material;
  dynamics.time_step = time_step;
  return Model(std::move(mesh), std::move(materials), std::move(fixed), dynamics);
}

/// A biliary tree held at both ends of the common bile duct, as in the paper; each region its own stiffness.
inline Model biliary_model(double time_step, int fineness = 1) {
  TetMesh mesh = biliary_mesh(fineness);
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (const VertexId v : mesh.tets[t])
      if (mesh.regions[t] == 4 && (mesh.position(v).z() < 0.002 || mesh.position(v).z() > 0.058)) fixed[v.index()] = 1;
  Dynamics dynamics;
  dynamics.time_step = time_step;
  dynamics.rayleigh_mass = 0.3;
  dynamics.rayleigh_stiffness = 0.002;
  return Model(std::move(mesh), {{2, {8.0e5, 0.45, 1000}}, {3, {1.2e6, 0.40, 1060}}, {4, {1.0e6, 0.45, 1050}}},
               std::move(fixed), dynamics);
}

}  // namespace calot::test
