// Inside this room only: what burning leaves and throws: char and soot on the tissue, sparks at the tip.
#pragma once
#include <vector>

#include "calot/view/effects/gas.h"
#include "calot/view/effects/sheet.h"

namespace calot::detail {

class Burns {
 public:
  Burns() = default;
  explicit Burns(const EffectsOptions& options) : options_(options), random_(options.seed + 0xf1a3) {}

  /// Finds where tips burn, and what has charred since the last snapshot.
  void take(const Snapshot& snapshot, Sheet& skin);
  void step(double dt, const Vec3f& gravity, Sheet& skin, MaskVolume& mask);
  void tell(EffectsState& state) const;
  [[nodiscard]] std::span<const BurningTip> tips() const { return tips_; }

 private:
  struct Spark {
    Vec3f position, velocity;
    float age = 0, life = 0.1F;
  };
  struct Soot {
    Vec3f rest = Vec3f::Zero();
    float value = 0, radius = 1e-3F;
  };
  void throw_sparks(double dt, const BurningTip& tip);

  EffectsOptions options_;
  std::vector<BurningTip> tips_;
  std::vector<Vec3f> tip_rests_;     // of the tissue under each tip
  std::vector<float> char_painted_;  // of each skin vertex, what its paint stands for
  std::uint64_t skin_version_ = ~std::uint64_t{0};
  std::vector<Soot> to_paint_;
  std::vector<Spark> sparks_;
  double spark_due_ = 0;
  RandomLine random_;
};

}  // namespace calot::detail
