// One contact with friction, solved exactly: open, stuck, or sliding by a root of one variable.
#include <Eigen/LU>
#include <cmath>

#include "calot/contact/friction.h"

namespace calot {
namespace {

/// Sliding: u_n = 0 and u_t = −κ λ_t with κ > 0. With λ_n eliminated, (S + κ I) λ_t = −p; in the eigenvectors of S
/// every κ has a closed form, and ‖λ_t‖ = μ λ_n is one equation for κ: positive at 0 (sticking was impossible) and
/// negative at infinity (there λ_n = −q_n/w_nn > 0).
class Sliding {
 public:
  Sliding(const Eigen::Matrix3d& w, const Eigen::Vector3d& q, double friction) : friction_(friction) {
    const double c = 1 / w(0, 0);
    const double a = w(1, 1) - w(1, 0) * w(1, 0) * c, b = w(1, 2) - w(1, 0) * w(2, 0) * c,
                 d = w(2, 2) - w(2, 0) * w(2, 0) * c;
    // Jacobi's rotation of a symmetric 2×2 matrix.
    const double angle = 0.5 * std::atan2(2 * b, a - d);
    cos_ = std::cos(angle);
    sin_ = std::sin(angle);
    const double mean = 0.5 * (a + d), reach = std::hypot(0.5 * (a - d), b);
    const double floor = 1e-14 * (w(1, 1) + w(2, 2));
    s_[0] = mean + reach;
    s_[1] = std::max(mean - reach, floor);
    turn(q(1) - w(1, 0) * c * q(0), q(2) - w(2, 0) * c * q(0), p_);
    turn(w(1, 0) * c, w(2, 0) * c, coupling_);
    pressed_ = -q(0) * c;
  }

  [[nodiscard]] Eigen::Vector3d solve() const {
    double low = 0, high = s_[0] + s_[1], kappa = 0;
    double slope = 0;
    for (int i = 0; i < 200 && excess(high, slope) > 0; ++i) {
      low = high;
      high *= 8;
    }
    kappa = low;
    // Newton's steps inside a shrinking bracket; bisection where they leave it.
    for (int i = 0; i < 100; ++i) {
      const double f = excess(kappa, slope);
      (f > 0 ? low : high) = kappa;
      double next = slope < 0 ? kappa - f / slope : 0.5 * (low + high);
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (std::abs(next - kappa) <= 1e-15 * (std::abs(kappa) + 1e-3 * s_[1]) || f == 0) break;
      kappa = next;
    }
    const double t0 = -p_[0] / (s_[0] + kappa), t1 = -p_[1] / (s_[1] + kappa);
    const double normal = std::max(0.0, pressed_ - coupling_[0] * t0 - coupling_[1] * t1);
    // On the cone to the last bit.
    const double length = std::hypot(t0, t1), scale = length > 0 ? friction_ * normal / length : 0;
    return {normal, scale * (cos_ * t0 - sin_ * t1), scale * (sin_ * t0 + cos_ * t1)};
  }

 private:
  void turn(double x, double y, double* out) const {
    out[0] = cos_ * x + sin_ * y;
    out[1] = -sin_ * x + cos_ * y;
  }

  /// ‖λ_t‖ − μ λ_n at κ, and its derivative.
  double excess(double kappa, double& slope) const {
    const double d0 = s_[0] + kappa, d1 = s_[1] + kappa, t0 = -p_[0] / d0, t1 = -p_[1] / d1;
    const double length = std::sqrt(t0 * t0 + t1 * t1);
    const double length_slope = length > 0 ? -(t0 * t0 / d0 + t1 * t1 / d1) / length : 0;
    slope = length_slope - friction_ * (coupling_[0] * t0 / d0 + coupling_[1] * t1 / d1);
    return length - friction_ * (pressed_ - coupling_[0] * t0 - coupling_[1] * t1);
  }

  double friction_, cos_ = 1, sin_ = 0, s_[2], p_[2], coupling_[2], pressed_ = 0;
};

}  // namespace

Eigen::Vector3d solve_one_contact(const Eigen::Matrix3d& w, const Eigen::Vector3d& q, double friction) {
  if (q(0) >= 0) return Eigen::Vector3d::Zero();
  if (friction == 0) return {-q(0) / w(0, 0), 0, 0};
  const Eigen::Vector3d stuck = -(w.inverse() * q);
  if (stuck(0) >= 0 && stuck.tail<2>().norm() <= friction * stuck(0)) return stuck;
  return Sliding(w, q, friction).solve();
}

}  // namespace calot
