// The linear (P1) tetrahedron.
#pragma once
#include <array>

#include "calot/fem/block_matrix.h"
#include "calot/mesh/tet_mesh.h"

namespace calot {

/// Isotropic linear elasticity. young > 0 [Pa], −1 < poisson < 0.5, density > 0 [kg/m³].
struct Material {
  double young = 1.0e6;
  double poisson = 0.45;
  double density = 1000.0;
  friend bool operator==(const Material&, const Material&) = default;
};

/// Lamé's parameters [Pa].
struct Lame {
  double lambda, mu;
};
Lame lame(const Material& material);

/// What a tet's stiffness needs of its shape: the gradients of the four shape functions [1/m] and the volume [m³].
struct TetShape {
  std::array<Vec3, 4> gradient;
  double volume;
};
TetShape tet_shape(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// The 3×3 block K_ab [N/m] of the element stiffness, a, b in 0 … 3:
/// V (λ g_a g_bᵀ + μ g_b g_aᵀ + μ (g_a·g_b) I). Source: docs/math.md §1.
inline Mat3 stiffness_block(const TetShape& shape, const Lame& lame, int a, int b) {
  const Vec3& ga = shape.gradient[static_cast<std::size_t>(a)];
  const Vec3& gb = shape.gradient[static_cast<std::size_t>(b)];
  Mat3 block = lame.lambda * (ga * gb.transpose()) + lame.mu * (gb * ga.transpose());
  block.diagonal().array() += lame.mu * ga.dot(gb);
  return shape.volume * block;
}

/// The whole 12×12 element stiffness K_e [N/m].
Eigen::Matrix<double, 12, 12> stiffness(const TetShape& shape, const Lame& lame);

}  // namespace calot
