#include "calot/scene/ligaments.h"

#include <Eigen/Dense>
#include <cmath>
#include <map>

#include "calot/mesh/parts.h"

namespace calot::detail {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

struct Load {
  double mass = 0;    // of all that isn't held in place [kg]
  double weight = 0;  // the mass that gravity acts on [kg]
  Vec3 centre = Vec3::Zero();
};

/// Of each group of vertices.
std::map<std::uint32_t, Load> loads_of(const Model& model, const std::vector<std::uint32_t>& groups,
                                       const std::set<std::int32_t>& carried) {
  const TetMesh& mesh = model.mesh();
  std::map<std::uint32_t, Load> loads;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const double mass = model.material(TetId(t)).density * signed_volume(mesh, TetId(t)) / 4;
    for (const VertexId v : mesh.tets[t]) {
      if (model.is_fixed(v)) continue;
      Load& load = loads[groups[v.index()]];
      load.mass += mass;
      if (carried.contains(mesh.regions[t])) continue;
      load.weight += mass;
      load.centre += mass * mesh.position(v);
    }
  }
  for (auto& [group, load] : loads)
    if (load.weight > 0) load.centre /= load.weight;
  return loads;
}

/// Shift and turn about the springs' middle by which the springs pull with `force` and `torque`; turns that they hardly
/// resist are left out.
Vec6 stretch_for(const std::vector<Vec3>& arms, double stiffness, const Vec3& force, const Vec3& torque) {
  // About their middle shift and turn don't mix.
  Mat3 resistance = Mat3::Zero();
  for (const Vec3& arm : arms) resistance += stiffness * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  const Eigen::SelfAdjointEigenSolver<Mat3> turning(resistance);
  const double least = 1e-3 * turning.eigenvalues()[2];
  Vec3 turn = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (turning.eigenvalues()[k] > std::max(least, 1e-12))
      turn += turning.eigenvectors().col(k).dot(torque) / turning.eigenvalues()[k] * turning.eigenvectors().col(k);
  Vec6 stretch;
  stretch << force / (stiffness * static_cast<double>(arms.size())), turn;
  return stretch;
}

void hang_body(const Model& model, const std::vector<VertexId>& held, const Load& load, const Vec3& gravity,
               std::vector<Spring>& springs) {
  constexpr double earth = 9.81;
  const auto& places = model.mesh().positions;
  const auto count = static_cast<double>(held.size());
  const double whole = load.mass * earth / ligament_give;
  Vec3 middle = Vec3::Zero();
  for (const VertexId v : held) middle += places[v.index()] / count;
  std::vector<Vec3> arms;
  for (const VertexId v : held) arms.emplace_back(places[v.index()] - middle);
  const Vec3 force = -load.weight * gravity, torque = (load.centre - middle).cross(force);
  const Vec6 stretch = stretch_for(arms, whole / count, force, torque);
  for (std::size_t k = 0; k < held.size(); ++k) {
    Spring spring;
    spring.vertex = held[k];
    spring.anchor = places[held[k].index()] + stretch.head<3>() + Vec3(stretch.tail<3>()).cross(arms[k]);
    spring.stiffness = whole / count * Mat3::Identity();
    spring.damping = 2 * ligament_damping * std::sqrt(load.mass / whole);
    springs.push_back(spring);
  }
}

}  // namespace

std::vector<Spring> hang(const Model& model, const std::vector<VertexId>& held, const std::set<std::int32_t>& carried,
                         const Vec3& gravity) {
  const std::vector<std::uint32_t> groups = vertex_connected_groups(model.mesh());
  const std::map<std::uint32_t, Load> loads = loads_of(model, groups, carried);
  std::map<std::uint32_t, std::vector<VertexId>> held_of_group;
  for (const VertexId v : held) held_of_group[groups[v.index()]].push_back(v);
  std::vector<Spring> springs;
  for (const auto& [group, vertices] : held_of_group) hang_body(model, vertices, loads.at(group), gravity, springs);
  return springs;
}

}  // namespace calot::detail
