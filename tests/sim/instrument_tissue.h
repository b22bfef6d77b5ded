// A piece of linear tissue to try instruments on: implicit Euler, solved directly, nothing else in the way.
#pragma once
#include <Eigen/Sparse>
#include <map>

#include "calot/fem/model.h"
#include "calot/mesh/surface.h"
#include "calot/sim/grasp_area.h"
#include "calot/sim/spring.h"

namespace calot::test {

class LinearTissue {
 public:
  LinearTissue(const TetMesh& mesh, const Material& material, std::vector<std::uint8_t> fixed, double step)
      : step_(step), fixed_(std::move(fixed)) {
    std::map<std::int32_t, Material> materials;
    for (const std::int32_t region : mesh.regions) materials[region] = material;
    const Model model(mesh, materials, fixed_, {.time_step = step});
    rest = positions = mesh.positions;
    velocities.assign(rest.size(), Vec3::Zero());
    masses_ = model.vertex_masses();
    const BlockMatrix k = model.stiffness();
    for (std::size_t row = 0; row < k.rows(); ++row)
      for (std::size_t e = k.row_start[row]; e < k.row_start[row + 1]; ++e)
        add(stiffness_, row, k.column[e], k.block[e]);
    for (const auto& t : boundary_surface_of(mesh)) triangles.push_back(t);
  }

  static std::vector<std::array<VertexId, 3>> boundary_surface_of(const TetMesh& mesh) {
    const Surface s = boundary_surface(mesh);
    std::vector<std::array<VertexId, 3>> result;
    for (const Triangle& t : s.triangles)
      result.push_back({s.vertex_of_mesh[t[0]], s.vertex_of_mesh[t[1]], s.vertex_of_mesh[t[2]]});
    return result;
  }

  [[nodiscard]] TissueSurface surface() const { return {triangles, positions}; }

  /// (M/h² + K + springs) d = M v/h + f − K (x − x0) + springs at d = 0
  void advance(const std::vector<Spring>& springs, const std::vector<Vec3>& forces = {}) {
    const auto n = static_cast<Eigen::Index>(3 * rest.size());
    std::vector<Eigen::Triplet<double>> entries = stiffness_;
    Eigen::VectorXd moved(n), b = Eigen::VectorXd::Zero(n);
    for (std::size_t v = 0; v < rest.size(); ++v) moved.segment<3>(at(v)) = positions[v] - rest[v];
    for (const auto& e : stiffness_) b[e.row()] -= e.value() * moved[e.col()];
    for (std::size_t v = 0; v < rest.size(); ++v) {
      add(entries, v, v, Mat3(masses_[v] / (step_ * step_) * Mat3::Identity()));
      b.segment<3>(at(v)) += masses_[v] / step_ * velocities[v];
      if (!forces.empty()) b.segment<3>(at(v)) += forces[v];
    }
    for (const Spring& s : springs) {
      const std::size_t v = s.vertex.index();
      add(entries, v, v, s.stiffness);
      Vec3 from = Vec3::Zero();
      if (s.other.valid()) {
        const std::size_t o = s.other.index();
        from = positions[o];
        add(entries, o, o, s.stiffness);
        add(entries, v, o, Mat3(-s.stiffness));
        add(entries, o, v, Mat3(-s.stiffness));
        b.segment<3>(at(o)) -= s.stiffness * (from + s.anchor - positions[v]);
      }
      b.segment<3>(at(v)) += s.stiffness * (from + s.anchor - positions[v]);
    }
    for (std::size_t v = 0; v < rest.size(); ++v)
      if (fixed_[v] != 0) {
        add(entries, v, v, Mat3(1e12 * Mat3::Identity()));
        b.segment<3>(at(v)).setZero();
      }
    Eigen::SparseMatrix<double> a(n, n);
    a.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(a);
    const Eigen::VectorXd d = factor.solve(b);
    for (std::size_t v = 0; v < rest.size(); ++v) {
      positions[v] += d.segment<3>(at(v));
      velocities[v] = d.segment<3>(at(v)) / step_;
    }
  }

  std::vector<Vec3> rest, positions, velocities;
  std::vector<std::array<VertexId, 3>> triangles;

 private:
  static Eigen::Index at(std::size_t v) { return static_cast<Eigen::Index>(3 * v); }
  static void add(std::vector<Eigen::Triplet<double>>& entries, std::size_t row, std::size_t column,
                  const Mat3& block) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        if (block(i, k) != 0)
          entries.emplace_back(static_cast<int>(3 * row) + i, static_cast<int>(3 * column) + k, block(i, k));
  }

  double step_;
  std::vector<std::uint8_t> fixed_;
  std::vector<double> masses_;
  std::vector<Eigen::Triplet<double>> stiffness_;
};

}  // namespace calot::test
