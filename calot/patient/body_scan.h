// Inside this room only: a coarse look at the body in a CT, on axes along RAS.
#pragma once
#include <optional>

#include "calot/patient/completion.h"

namespace calot::detail {

/// The CT in cubes of 2 mm. Cell (i, j, k) is number i + size[0]·(j + size[1]·k).
struct BodyScan {
  static constexpr double cell = 2e-3;  ///< [m]
  enum Kind : std::uint8_t {
    outside_field,
    air,
    tissue,  ///< HU above −300, but not joined to the organs: table, cables
    body,
  };
  std::array<std::size_t, 3> size{};
  Vec3 origin;                           ///< centre of cell (0, 0, 0) [m]
  std::vector<std::uint8_t> kind;        ///< of each cell
  std::vector<std::int16_t> hounsfield;  ///< of its middle
  std::vector<std::uint8_t> organ;       ///< 1: labelled, other than fat

  explicit BodyScan(const CompletedAnatomy& anatomy);
  [[nodiscard]] std::size_t index(std::size_t i, std::size_t j, std::size_t k) const {
    return i + size[0] * (j + size[1] * k);
  }
  [[nodiscard]] double at(int axis, std::size_t i) const { return origin[axis] + cell * static_cast<double>(i); }

  /// The body's middle, half its width, and its right side, as medians over the slices that show them.
  struct Sides {
    std::optional<double> middle, half_width, right;  ///< x [m]
  };
  [[nodiscard]] Sides sides() const;
  /// The middle of the vertebral column: bone behind and to the left of the bile duct. Empty where the field doesn't
  /// hold it whole.
  [[nodiscard]] std::optional<double> spine(const Vec3& bile_duct) const;
  /// The largest x of an organ [m].
  [[nodiscard]] double organs_right() const;

 private:
  void sample(const CompletedAnatomy& anatomy);
  void flood();
  [[nodiscard]] bool mostly_air(std::size_t i, std::size_t k) const;
};

}  // namespace calot::detail
