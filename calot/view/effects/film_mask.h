// Inside this room only: the film that runs leave behind, as the mask holds it. Every unit of a voxel stands for so
// much liquid, so that nothing gets lost by rounding.
#pragma once
#include <array>

#include "calot/sim/tissue_properties.h"
#include "calot/view/effects/mask_volume.h"

namespace calot::detail {

/// Where a film is laid: an ellipse on the surface, at rest.
struct FilmSpot {
  Eigen::Vector3f rest = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::UnitZ();
  float radius = 1e-3F;  ///< [m]
};

class FilmMask {
 public:
  FilmMask() = default;
  FilmMask(const Eigen::AlignedBox3f& box, float voxel, std::size_t most_bytes) : mask_(box, voxel, most_bytes) {}

  /// Raises a film to `thickness` [m] (60 µm at most) with what is `available` [m³], and wets. @return what it took
  double lay(Fluid fluid, const FilmSpot& spot, double thickness, double available);
  /// Takes film up within a ball, at most `room` [m³]; leaves it wet. @return taken blood and bile
  std::array<double, 2> wipe(const Eigen::Vector3f& rest, float radius, double room);
  /// What was laid down without a voxel to hold it: outside of the volume, or less than a unit.
  void absorb(Fluid fluid, double volume) { loose_[index(fluid)] += volume; }
  /// A step of drying, in `time` from wet to dry [s].
  void dry(double dt, double time);

  [[nodiscard]] double volume(Fluid fluid) const;                            ///< of all film [m³]
  [[nodiscard]] float film(const Eigen::Vector3f& rest, Fluid fluid) const;  ///< film in the nearest voxel, 0 … 1
  [[nodiscard]] float wet(const Eigen::Vector3f& rest) const;                ///< 0 … 1
  [[nodiscard]] MaskVolume& mask() { return mask_; }
  [[nodiscard]] const MaskVolume& mask() const { return mask_; }
  [[nodiscard]] double unit() const;  ///< of a voxel's value [m³]

 private:
  static constexpr std::size_t index(Fluid fluid) { return fluid == Fluid::blood ? 0 : 1; }
  [[nodiscard]] float value(const Eigen::Vector3f& rest, MaskChannel channel) const;

  MaskVolume mask_;
  std::array<std::int64_t, 2> units_{};
  std::array<double, 2> loose_{};
  double drying_ = 0;     // steps of drying that are due, of all bricks
  std::size_t next_ = 0;  // brick to dry
};

}  // namespace calot::detail
