// Blood, bile, smoke, char and sparks of a run: made from snapshots alone, on one core, without OpenGL.
//
//   Effects effects(first_snapshot, still_surfaces);
//   effects.advance(snapshot, snapshot.step - effects.state().step);   // for each snapshot that the view takes
//   renderer.draw(snapshot, effects.state());                          // effects_state.h says how to draw it
//
// The same snapshots and steps give the same bytes, on any machine with the same arithmetic.
#pragma once
#include <memory>
#include <span>

#include "calot/view/effects/effects_state.h"

namespace calot {

struct EffectsOptions {
  std::uint64_t seed = 1;
  float voxel = 0.75e-3F;                                         ///< of the mask, 0.2 … 5 mm [m]
  std::size_t mask_bytes = 8U << 20U;                             ///< the mask takes at most; larger voxels otherwise
  std::size_t parcels = 2000;                                     ///< of fluid that runs, at most
  std::size_t pools = 64, drops = 256, puffs = 400, sparks = 96;  ///< at most
  double blood_viscosity = 3.5e-3, bile_viscosity = 1.0e-3;       ///< [Pa s]
  double retention = 0.04;  ///< how strongly dry tissue holds a running front back, share of the surface tension, 0 … 1
  double left_behind = 0.25;      ///< share of a running film's thickness that stays on dry tissue, 0 … 1
  double clotting_time = 240;     ///< until blood that lies still is dark [s]
  double drying_time = 90;        ///< of what is wet [s]
  double gas_volume = 3e-3;       ///< of the abdomen, in which haze spreads [m³]
  double gas_exchange = 3.3e-5;   ///< that clears the haze by itself, 2 L a minute [m³/s]
  double gas_suction = 2e-4;      ///< that an open suction tube takes, 12 L a minute [m³/s]
  double smoke_per_joule = 7e-9;  ///< of what reaches tissue [kg/J]; assumed
};

class Effects {
 public:
  /// Begins with nothing on the tissue of this snapshot; sources count from what they have shed by then.
  /// @param still  surfaces that don't move: drops land there
  /// Throws InputError for options out of range.
  explicit Effects(const Snapshot& first, std::span<const Surface> still = {}, const EffectsOptions& options = {});
  ~Effects();
  Effects(Effects&&) noexcept;
  Effects& operator=(Effects&&) noexcept;

  /// Goes `steps` steps of snapshot.time_step on, with what the snapshot says of the world at their end.
  /// Never throws for what a snapshot holds: triangles without area, an empty skin, figures that aren't finite.
  void advance(const Snapshot& snapshot, std::uint64_t steps);
  [[nodiscard]] const EffectsState& state() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace calot
