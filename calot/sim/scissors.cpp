#include "calot/sim/scissors.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/sim/instrument_state.h"

namespace calot {

Scissors::Scissors(const InstrumentGeometry& geometry, double opening, const ScissorsFigures& figures)
    : geometry_(geometry), figures_(figures), opening_(opening), stroke_opening_(opening) {
  if (!(geometry.blade_offset > 0) || !geometry.has_jaws())
    throw InputError(std::string(name_of(geometry.kind)), "has no blades", "make Scissors for scissors only");
}

double Scissors::crossing(double opening) const {
  const double sine = std::sin(opening / 2);
  return sine * geometry_.jaw_length > geometry_.blade_offset ? geometry_.blade_offset / sine : geometry_.jaw_length;
}

double Scissors::half_gap(double r, double opening) const {
  return std::max(0.0, (r * std::sin(opening / 2) - geometry_.blade_offset) / std::cos(opening / 2));
}

/// How far up and down the sweep reaches at r.
double Scissors::half_height(double r) const {
  const double share = std::clamp(r / geometry_.jaw_length, 0.0, 1.0);
  const double depth = geometry_.blade_depth + share * (geometry_.blade_tip_depth - geometry_.blade_depth);
  return std::min(half_gap(r, stroke_opening_), half_gap(r, opening_) + depth) + figures_.margin;
}

Sweep Scissors::close(const Pose& from, const Pose& to, double opening) {
  Sweep sweep;
  opening = std::clamp(opening, 0.0, geometry_.max_opening);
  const double start = crossing(opening_), end = crossing(opening);
  const bool advances = (to * Vec3(0, 0, end) - from * Vec3(0, 0, start)).dot(from.rotation * Vec3::UnitZ()) > 0;
  if (opening < opening_ && end > start && advances) {
    const double first = std::max(0.0, start - figures_.overlap);
    const int pieces = std::max(1, static_cast<int>(std::ceil((end - first) / figures_.piece)));
    std::array<Vec3, 2> last;
    for (int k = 0; k <= pieces; ++k) {
      const double r = first + (end - first) * k / pieces, share = std::max(0.0, (r - start) / (end - start));
      const Pose pose{from.rotation.slerp(share, to.rotation),
                      Vec3(from.position + share * (to.position - from.position))};
      const double height = half_height(std::max(r, start));
      const std::array<Vec3, 2> rung{pose * Vec3(0, -height, r), pose * Vec3(0, height, r)};
      if (k > 0) {
        sweep.triangles.push_back({last[0], rung[0], rung[1]});
        sweep.triangles.push_back({last[0], rung[1], last[1]});
      }
      last = rung;
    }
  }
  if (opening > opening_) stroke_opening_ = opening;
  opening_ = opening;
  return sweep;
}

void Scissors::append_state(std::string& bytes) const {
  detail::append_bytes(bytes, opening_);
  detail::append_bytes(bytes, stroke_opening_);
}

}  // namespace calot
