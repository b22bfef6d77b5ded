// Inside this room only: smoke and steam in the abdomen, as puffs that spread and thin out into an even haze.
#pragma once
#include <vector>

#include "calot/view/effects/effects.h"
#include "calot/view/effects/noise.h"

namespace calot::detail {

struct Puff {
  Vec3f position = Vec3f::Zero(), velocity = Vec3f::Zero();  ///< [m], [m/s]
  double mass = 0;                                           ///< [kg]
  float spread = 1e-3F;                                      ///< standard deviation of its density [m]
  float heat = 1;                                            ///< what lifts it, 1 … 0
  float age = 0;                                             ///< [s]
  float turn = 0, spin = 0, seed = 0;
  PuffKind kind = PuffKind::smoke;
};

/// A tip that burns tissue.
struct BurningTip {
  Vec3f place = Vec3f::Zero(), outwards = Vec3f::UnitZ();  ///< on the tissue [m]; its normal there, unit
  double power = 0;                                        ///< that reaches tissue [W]
};

class Gas {
 public:
  Gas() = default;
  explicit Gas(const EffectsOptions& options);
  /// @param suctions  tips of open suction tubes [m]
  /// @param up        against gravity, unit
  /// @param ceiling   height along `up` that nothing rises beyond [m]
  void step(double dt, std::span<const BurningTip> tips, std::span<const Vec3f> suctions, const Vec3f& up,
            float ceiling);
  void tell(EffectsState& state) const;

  [[nodiscard]] const std::vector<Puff>& puffs() const { return puffs_; }
  [[nodiscard]] double haze_mass() const { return haze_; }  ///< [kg]
  [[nodiscard]] double made() const { return made_; }       ///< since the start [kg]
  [[nodiscard]] double taken() const { return taken_; }     ///< by suction and exchange [kg]
  [[nodiscard]] double smoke_in_puffs() const;              ///< [kg]

 private:
  void give_off(double dt, const BurningTip& tip, std::size_t index);
  void add(Puff puff);
  void move(Puff& puff, double dt, std::span<const Vec3f> suctions, const Vec3f& up, float ceiling);

  EffectsOptions options_;
  std::vector<Puff> puffs_;  // oldest first
  std::vector<double> due_;  // of each tip: energy not given off yet [J]
  double haze_ = 0, made_ = 0, taken_ = 0;
  double time_ = 0;
  RandomLine random_;
};

}  // namespace calot::detail
