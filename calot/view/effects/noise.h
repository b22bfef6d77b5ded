// Inside this room only: numbers that look random and are the same every time.
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

namespace calot::detail {

/// Three well-mixed words from three. Source: [Jarzynski2020], pcg3d.
std::array<std::uint32_t, 3> mix3(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// Numbers in order; the state is the seed and how many were drawn.
class RandomLine {
 public:
  explicit RandomLine(std::uint64_t seed = 1) : seed_(seed) {}
  float unit();               ///< 0 … 1, below 1
  float symmetric();          ///< −1 … 1
  Eigen::Vector3f in_ball();  ///< even in the unit ball
  [[nodiscard]] std::uint64_t drawn() const { return count_; }

 private:
  std::uint64_t seed_, count_ = 0;
};

/// Smooth noise, −1 … 1, with features of about 1.
float value_noise(const Eigen::Vector3f& p, std::uint32_t seed);

/// Curl of a smooth random vector potential: a divergence-free field that looks turbulent, of speed about 1, eddies of
/// about 1. Source: [Bridson2007]; the derivatives are exact.
Eigen::Vector3f curl_noise(const Eigen::Vector3f& p, std::uint32_t seed);

}  // namespace calot::detail
