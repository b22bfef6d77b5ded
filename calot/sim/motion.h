// One implicit step of the tissue: free motion, and the answer to forces on it.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "calot/sim/corotational.h"
#include "calot/sim/spring.h"
#include "calot/sim/tissue_state.h"

namespace calot {

struct SolverOptions {
  double tolerance = 1e-2;  ///< of ‖b − Â d‖/‖b‖; a linear step is off by more than that where tissue turns
  int iterations = 15;      ///< at most; a step that needs more says so and goes on with what it has
};

struct SolverReport {
  int iterations = 0;
  double residual = 0;  ///< ‖b − Â d‖/‖b‖ reached
  bool converged = true;
};

/// z ≈ Â⁻¹ r, symmetric positive definite; n vectors each.
struct Preconditioner {
  std::function<void(std::span<const Vec3> r, std::span<Vec3> z)> apply;
  bool mixes_parts = false;  ///< parts that hang together by nothing see each other's rounding
};

/// Â d = b of one step, with Â = ((1 + hα) M + (h² + hβ) K_R)/h² + springs and d the displacement within the step;
/// fixed vertices stay. Tissue is what `Corotational` says at the rotations it has. Source: docs/simulation.md.
class Motion {
 public:
  Motion() = default;
  explicit Motion(const Model& model);
  /// After an edit or a change of stiffness.
  void follow(const Model& model);

  /// Begins a step: what acts on the tissue. External forces [N] are n, or empty.
  /// b = M v/h + f_elastic(x) + M g + f_external + springs.
  void begin(const Corotational& tissue, const TissueState& state, const Vec3& gravity, std::span<const Spring> springs,
             std::span<const Vec3> external);
  /// The displacement d of the begun step, by conjugate gradients from as much of the last step's as is good for each
  /// part; were the cap on iterations to bind, the step's energy would still be no higher than at rest.
  SolverReport solve_free(const Preconditioner& preconditioner, const SolverOptions& options, std::span<Vec3> d);
  /// Adds Â⁻¹ f to d, by conjugate gradients from rest; f is 0 on fixed vertices.
  SolverReport add_response(std::span<const Vec3> f, const Preconditioner& preconditioner, const SolverOptions& options,
                            std::span<Vec3> d);
  /// y = Â x; zero on fixed vertices.
  void multiply(std::span<const Vec3> x, std::span<Vec3> y) const;

  /// Ends the begun step, whose displacements were d, once `tissue` (the same object) has been turned for the new
  /// positions. @return how far the linear step is from the true corotational one: ‖M (v' − v)/h − all forces at the
  /// end of the step, rotations and elastic forces taken anew‖ / the largest of ‖b‖, ‖f_elastic‖ and ‖M g‖ (at rest
  /// they balance, and b is nothing). `contact`: contact forces [N], n or empty.
  double finish(const TissueState& before, const TissueState& after, std::span<const Vec3> contact);

  /// Parts that nothing joins in the begun step, neither tets nor springs, are solved each for itself, so that one does
  /// not feel the other to the last bit. Of each vertex, its part's number, below `part_count`.
  [[nodiscard]] std::span<const std::uint32_t> parts() const { return part_; }
  [[nodiscard]] std::size_t part_count() const { return part_count_; }

  /// The same by tets alone, springs not counted; of the mesh as it is.
  [[nodiscard]] std::span<const std::uint32_t> groups() const { return group_; }
  [[nodiscard]] std::size_t group_count() const { return group_count_; }

  [[nodiscard]] const std::vector<double>& masses() const { return masses_; }
  [[nodiscard]] std::span<const Vec3> right_side() const { return b_; }
  [[nodiscard]] double time_step() const { return dynamics_.time_step; }

 private:
  void join_parts();
  void precondition(const Preconditioner& preconditioner);
  void go_plain_where_lost();
  void sum_by_part(std::span<const Vec3> a, std::span<const Vec3> b, std::vector<double>& sums) const;
  SolverReport conjugate_gradients(std::span<const Vec3> b, const Preconditioner& preconditioner,
                                   const SolverOptions& options, std::span<Vec3> d);
  void add_springs(const TissueState& state);

  Dynamics dynamics_;
  std::vector<double> masses_;
  std::vector<std::uint8_t> fixed_;
  const Corotational* tissue_ = nullptr;  // of the begun step
  std::span<const Spring> springs_;
  Vec3 gravity_ = Vec3::Zero();
  std::vector<Vec3> external_;
  std::vector<Vec3> elastic_;  // force at the positions where the last step ended
  bool elastic_is_fresh_ = false;
  std::vector<Vec3> b_, r_, z_, p_, q_, inertia_, response_, masked_, answer_;
  std::vector<std::uint32_t> group_, part_;  // n: joined by tets; and by springs too
  std::size_t group_count_ = 0, part_count_ = 0;
  struct PartState {
    double scale = 0, residual = 0, descent = 0, before = 0;
    bool active = false, plain = false;
  };
  std::vector<PartState> state_of_part_;
  std::vector<double> sums_, weight_of_part_;
};

}  // namespace calot
