// Friction problems for the tests: random ones, and ones of contacts with a finite-element model.
#pragma once
#include <Eigen/Geometry>
#include <string>

#include "calot/compliance/compliance.h"
#include "calot/contact/friction.h"
#include "calot/mesh/surface.h"
#include "tests/support/models.h"

namespace calot::test {

inline double normal_number(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.unit();
  return sum;
}

/// W = A Aᵀ with `modes` columns: singular where modes < 3·contacts.
inline FrictionProblem random_problem(Random& random, int contacts, int modes, double friction) {
  Eigen::MatrixXd a(3 * contacts, modes);
  for (double& value : a.reshaped()) value = normal_number(random);
  FrictionProblem problem;
  problem.delassus = 1e-3 / modes * (a * a.transpose());
  Eigen::VectorXd through(modes);  // a motion that forces can undo, and gaps on top
  for (double& value : through.reshaped()) value = normal_number(random);
  problem.free_motion = 1e-3 * (a * through) / std::sqrt(double(modes));
  for (int i = 0; i < contacts; ++i) problem.free_motion(3 * i) += 1e-3 * random.unit();
  problem.friction.assign(static_cast<std::size_t>(contacts), friction);
  return problem;
}

/// Contacts on the surface of a cut-free biliary tree within a patch: W = J C Jᵀ of its compliance at a step of 16 ms.
class TissuePatch {
 public:
  TissuePatch() : model_(biliary_model(1.0 / 60)), compliance_(precompute(model_)) {
    surface_ = boundary_surface(model_.mesh());
  }

  /// `contacts` points within `reach` of the gallbladder's flank, pressed in by about 1 mm and dragged sideways.
  [[nodiscard]] FrictionProblem problem(Random& random, int contacts, double reach, double friction) const {
    const Vec3 middle(0.045, 0.03, 0.035);
    const auto n = static_cast<Eigen::Index>(3 * model_.mesh().vertex_count());
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3 * contacts, n);
    FrictionProblem problem;
    problem.free_motion.resize(3 * contacts);
    problem.friction.assign(static_cast<std::size_t>(contacts), friction);
    const double drag = 2e-3 * random.unit();
    for (int i = 0; i < contacts;) {
      const Triangle& t = surface_.triangles[random.below(surface_.triangles.size())];
      Vec3 weights(random.unit(), random.unit(), random.unit());
      weights /= weights.sum();
      Vec3 point = Vec3::Zero();
      for (int c = 0; c < 3; ++c) point += weights(c) * surface_.positions[t[c]];
      if ((point - middle).norm() > reach) continue;
      const Vec3 out = (surface_.positions[t[1]] - surface_.positions[t[0]])
                           .cross(surface_.positions[t[2]] - surface_.positions[t[0]])
                           .normalized();
      Eigen::Matrix3d frame;  // rows: normal from the partner to the tissue, two tangents
      frame.row(0) = -out.transpose();
      frame.row(1) = out.unitOrthogonal().transpose();
      frame.row(2) = frame.row(0).cross(frame.row(1));
      for (int c = 0; c < 3; ++c) {
        const auto v = static_cast<Eigen::Index>(surface_.vertex_of_mesh[t[c]].index());
        jacobian.block<3, 3>(3 * i, 3 * v) = weights(c) * frame;
      }
      const Vec3 moved = drag * Vec3(1, 0.3, 0.2);
      problem.free_motion.segment<3>(3 * i) = frame * moved;
      problem.free_motion(3 * i) += 1e-3 * (0.3 - random.unit());
      ++i;
    }
    problem.delassus = jacobian * compliance_.apply(jacobian.transpose());
    problem.delassus = (0.5 * (problem.delassus + problem.delassus.transpose())).eval();
    return problem;
  }

 private:
  Model model_;
  Compliance compliance_;
  Surface surface_;
};

}  // namespace calot::test
