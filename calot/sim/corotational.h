// Corotational linear elasticity on all tets of a mesh at once.
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "calot/fem/model.h"

namespace calot {

/// Elastic forces of P1 tets in the corotational form: each tet is linear in the frame of its own rotation R, the
/// orthogonal factor of its deformation gradient F. Tets are kept eight at a time, so that one instruction serves many.
/// Results don't depend on the number of threads. Source: [Mueller2002], [Hauth2004]; docs/simulation.md.
class Corotational {
 public:
  Corotational() = default;
  /// Rotations start at the identity.
  explicit Corotational(const Model& model);

  /// Rotations of all tets for these positions (n), by Newton's method from the rotations before: at most four
  /// iterations. @return the largest angle [rad] that the last of them still turned a tet by
  double update_rotations(std::span<const Vec3> positions);

  /// f = elastic force [N] on every vertex at `positions` with the rotations as they are; n each.
  void force(std::span<const Vec3> positions, std::span<Vec3> out) const;
  /// y = K_R d: elastic stiffness in the rotated frames times displacements [m], with the rotations as they are; n
  /// each.
  void multiply(std::span<const Vec3> displacements, std::span<Vec3> out) const;

  /// Elastic energy [J] at `positions` with the rotations as they are.
  [[nodiscard]] double energy(std::span<const Vec3> positions) const;

  [[nodiscard]] std::size_t tet_count() const { return tet_count_; }
  [[nodiscard]] Eigen::Quaterniond rotation(TetId tet) const;
  [[nodiscard]] std::vector<Eigen::Quaterniond> rotations() const;
  void set_rotations(std::span<const Eigen::Quaterniond> rotations);

  /// Brings tets up to date after an edit that `model` has taken; new pieces start with their parent's rotation.
  void follow(const Model& model, const Remap& remap);
  /// The same after a change of stiffness only.
  void restiffen(const Model& model);

 private:
  static constexpr std::size_t lanes = 8;
  using Lane = std::array<double, lanes>;
  struct Block {  // of eight tets; unused lanes have no stiffness
    std::array<std::array<std::uint32_t, lanes>, 4> vertex;
    std::array<Lane, 9> gradient;  // of corners 1, 2, 3 [1/m], row-major by corner
    Lane lambda, two_mu;           // times the volume [J]
  };
  struct BlockRotation {
    std::array<Lane, 4> quaternion;  // w, x, y, z
    std::array<Lane, 9> gradient;    // of corners 1, 2, 3, turned
  };
  enum class Product { force, linear };
  template <Product product>
  void apply(std::span<const Vec3> in, std::span<Vec3> out) const;
  static void block_forces(const Block& block, const BlockRotation& rotation, const double* in, double identity,
                           double* out);
  static void turn_gradient(const Block& block, BlockRotation& rotation);
  static double rotate_block(const Block& block, BlockRotation& rotation, const double* positions);
  static double block_energy(const Block& block, const BlockRotation& rotation, const double* positions);
  void rebuild(const Model& model);
  void sum_corners(std::span<Vec3> out) const;

  std::size_t tet_count_ = 0, vertex_count_ = 0;
  std::vector<Block> blocks_;
  std::vector<BlockRotation> rotations_;
  std::vector<std::uint32_t> corner_start_, corner_;  // of each vertex: where its corners' forces stand, tets ascending
  mutable std::vector<double> corner_forces_;         // 3 for each corner of each tet
};

}  // namespace calot
