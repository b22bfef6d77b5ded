#include "calot/view/effects/burns.h"

#include <algorithm>
#include <cmath>

namespace calot::detail {
namespace {

constexpr float reach = 5e-3F;            // from a tip to the tissue it burns [m]
constexpr double sparks_per_joule = 2.2;  // assumed
constexpr std::size_t painted_in_a_step = 48;
constexpr float noticeable = 0.06F;  // change of charring

/// The middle of what of a tool burns.
Vec3f burning_point(const InstrumentSnapshot& tool) {
  const InstrumentGeometry geometry = instrument_geometry(tool.kind);
  const Vec3 tip = tool.kind == InstrumentKind::hook ? Vec3(0.5 * (geometry.hook_heel + geometry.hook_tip))
                                                     : Vec3(0, 0, geometry.jaw_length);
  return (tool.pose * tip).cast<float>();
}

}  // namespace

void Burns::take(const Snapshot& snapshot, Sheet& skin) {
  tips_.clear();
  tip_rests_.clear();
  for (const InstrumentSnapshot& tool : snapshot.instruments) {
    if (!(tool.cautery > 0) || !std::isfinite(tool.cautery)) continue;
    const Vec3f at = burning_point(tool);
    const auto near = skin.nearest(at, reach);
    if (!near) continue;
    tips_.push_back({skin.position(near->seat), skin.normal(near->seat.triangle), tool.cautery});
    tip_rests_.push_back(skin.rest(near->seat));
  }
  const std::size_t count = std::min(snapshot.conditions.size(), snapshot.skin.vertices.size());
  if (snapshot.skin.version != skin_version_) {
    // What was painted stays in the mask; painting it again changes nothing.
    char_painted_.assign(count, 0);
    skin_version_ = snapshot.skin.version;
  }
  for (std::size_t v = 0; v < std::min(count, char_painted_.size()); ++v) {
    const float charred = snapshot.conditions[v].charred;
    if (!(charred > char_painted_[v] + noticeable) || to_paint_.size() > 20000) continue;
    char_painted_[v] = charred;
    to_paint_.push_back({snapshot.skin.vertices[v].rest, 255 * std::min(1.0F, charred), 1.3e-3F});
  }
}

void Burns::throw_sparks(double dt, const BurningTip& tip) {
  spark_due_ += sparks_per_joule * tip.power * dt;
  for (; spark_due_ >= 1; spark_due_ -= 1) {
    if (sparks_.size() >= options_.sparks) {
      if (sparks_.empty()) continue;
      sparks_.erase(sparks_.begin());
    }
    Spark spark;
    spark.position = tip.place + 0.6e-3F * random_.in_ball();
    const Vec3f way = (tip.outwards + 1.1F * random_.in_ball()).normalized();
    spark.velocity = (0.15F + 0.9F * random_.unit() * random_.unit()) * way;
    spark.life = 0.03F + 0.14F * random_.unit() * random_.unit();
    sparks_.push_back(spark);
  }
}

void Burns::step(double dt, const Vec3f& gravity, Sheet& /*skin*/, MaskVolume& mask) {
  const auto h = static_cast<float>(dt);
  for (Spark& spark : sparks_) {
    spark.velocity += h * gravity;
    spark.velocity *= std::exp(-h / 0.15F);  // air slows what is so light
    spark.position += h * spark.velocity;
    spark.age += h;
  }
  std::erase_if(sparks_, [](const Spark& spark) { return spark.age >= spark.life; });
  for (std::size_t i = 0; i < tips_.size(); ++i) {
    throw_sparks(dt, tips_[i]);
    if (mask.bytes() == 0) continue;
    // Soot beside the tip: specks within 4 mm, darker the nearer; a few in a second at 30 W.
    if (random_.unit() > 0.02F * static_cast<float>(tips_[i].power)) continue;
    const Vec3f off = random_.in_ball();
    const float near = 1 - off.norm();
    mask.paint(MaskChannel::charred, tip_rests_[i] + 3.5e-3F * off, 0.5e-3F + 0.7e-3F * near, 60 + 110 * near, 0.5F);
  }
  const std::size_t some = std::min(to_paint_.size(), painted_in_a_step);
  for (std::size_t i = 0; i < some; ++i)
    mask.paint(MaskChannel::charred, to_paint_[i].rest, to_paint_[i].radius, to_paint_[i].value, 0.45F);
  to_paint_.erase(to_paint_.begin(), to_paint_.begin() + static_cast<std::ptrdiff_t>(some));
}

void Burns::tell(EffectsState& state) const {
  state.sparks.clear();
  for (const Spark& spark : sparks_)
    state.sparks.push_back({spark.position, spark.velocity, 1 - spark.age / spark.life});
}

}  // namespace calot::detail
