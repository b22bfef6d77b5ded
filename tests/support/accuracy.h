// The error that every numerical claim is made in.
#pragma once
#include "calot/compliance/compliance.h"
#include "tests/support/models.h"

namespace calot::test {

/// The worst column of ‖c − c*‖∞/‖c*‖∞ against `reference`, refined both.
inline double worst_column(const Compliance& compliance, const Compliance& reference, const std::vector<DofId>& dofs) {
  const Eigen::MatrixXd c = compliance.columns(dofs), r = reference.columns(dofs);
  double worst = 0;
  for (Eigen::Index j = 0; j < c.cols(); ++j) {
    const double scale = r.col(j).cwiseAbs().maxCoeff();
    const double error = (c.col(j) - r.col(j)).cwiseAbs().maxCoeff();
    worst = std::max(worst, scale > 0 ? error / scale : error);
  }
  return worst;
}

/// What an update may be off by: max(1e-9, 10 ε κ₁).
inline double bound(const Compliance& reference) {
  return std::max(1e-9, 10 * 2.2e-16 * reference.condition());
}

/// Dofs spread over the mesh, and all three of each vertex in `near`.
inline std::vector<DofId> sample_dofs(std::size_t vertices, const std::vector<VertexId>& near = {}) {
  std::vector<DofId> dofs;
  for (std::size_t k = 0; k < 12 && vertices > 0; ++k)
    dofs.push_back(dof_of(VertexId(k * 7919 % vertices), static_cast<int>(k % 3)));
  for (const VertexId v : near)
    for (int a = 0; a < 3; ++a) dofs.push_back(dof_of(v, a));
  return dofs;
}

/// The vertices at the face of a cut, in numbers after it.
inline std::vector<VertexId> cut_face(const StiffnessChange& change) {
  std::vector<VertexId> vertices;
  for (const VertexId v : change.touched) vertices.push_back(change.remap.vertex_to_new[v.index()]);
  return vertices;
}

}  // namespace calot::test
