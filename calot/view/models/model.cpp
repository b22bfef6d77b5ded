#include "calot/view/models/model.h"

#include <cmath>

#include "calot/sim/clip_section.h"
#include "calot/view/models/pieces.h"

namespace calot {
namespace {

constexpr double mm = detail::model_mm;
constexpr double leg_half_width = 0.5 * mm, leg_half_depth = 0.42 * mm;

Vec3 grain_along_legs(const Vec3& /*point*/) {
  return Vec3::UnitZ();
}

/// Wire of a clip along a path in the plane of y and z, from the tip of leg a round the bow to that of leg b.
ModelPart clip_wire(const std::vector<Vec3>& middle) {
  std::vector<Vec3> path;
  std::vector<double> scale;
  const auto add = [&](const Vec3& at, double share) {
    path.push_back(at);
    scale.push_back(share);
  };
  const Vec3 first = (middle[1] - middle[0]).normalized(),
             last = (middle.back() - middle[middle.size() - 2]).normalized();
  add(middle.front() - 0.45 * mm * first, 0.55);
  add(middle.front() - 0.32 * mm * first, 0.8);
  add(middle.front() - 0.1 * mm * first, 0.97);
  for (std::size_t k = 0; k < middle.size(); ++k) add(middle[k] + (k == 0 ? 0.05 * mm * first : Vec3(Vec3::Zero())), 1);
  path.back() -= 0.05 * mm * last;
  add(middle.back() + 0.1 * mm * last, 0.97);
  add(middle.back() + 0.32 * mm * last, 0.8);
  add(middle.back() + 0.45 * mm * last, 0.55);
  detail::PlainMesh mesh;
  detail::add_rod(mesh, path, scale, detail::rounded_rectangle(leg_half_width, leg_half_depth, 0.16 * mm, 3),
                  Vec3::UnitX());
  return detail::finish(mesh, ModelFrame::shaft, ModelMaterial::titanium, detail::usual_crease, grain_along_legs);
}

/// An arc about x from `from` to `to`, that leaves along `out` and arrives along `in` (a cubic).
void add_bend(std::vector<Vec3>& path, const Vec3& from, const Vec3& out, const Vec3& to, const Vec3& in) {
  constexpr int steps = 8;
  for (int k = 1; k < steps; ++k) {
    const double t = static_cast<double>(k) / steps, u = 1 - t;
    path.push_back(u * u * u * from + 3 * u * u * t * (from + out) + 3 * u * t * t * (to - in) + t * t * t * to);
  }
}

}  // namespace

std::vector<ModelPart> instrument_model(const InstrumentGeometry& geometry) {
  switch (geometry.kind) {
    case InstrumentKind::bowel_grasper:
      return detail::bowel_grasper_model(geometry);
    case InstrumentKind::curved_forceps:
      return detail::curved_forceps_model(geometry);
    case InstrumentKind::clip_applier:
      return detail::clip_applier_model(geometry);
    case InstrumentKind::scissors:
      return detail::scissors_model(geometry);
    case InstrumentKind::hook:
      return detail::hook_model(geometry);
    case InstrumentKind::suction:
      return detail::suction_model(geometry);
    case InstrumentKind::fan_retractor:
      return detail::fan_retractor_model(geometry);
  }
  return {};
}

ModelPart loaded_clip_model(const InstrumentGeometry& geometry, double opening) {
  const ArticulatedPoses poses = articulate(geometry, opening);
  const double tip = geometry.jaw_length - 0.9 * mm, root = geometry.jaw_length - 0.5 * mm - ClipFigures{}.leg_length;
  const double inside = 0.14 * mm;  // of the jaw's face: its channel is 0.28 mm deep
  const Vec3 a_tip = poses.jaw_a * Vec3(0, inside, tip), a_root = poses.jaw_a * Vec3(0, inside, root + 0.8 * mm);
  const Vec3 b_tip = poses.jaw_b * Vec3(0, -inside, tip), b_root = poses.jaw_b * Vec3(0, -inside, root + 0.8 * mm);
  std::vector<Vec3> path{a_tip, a_root};
  const Vec3 apex(0, 0, root - 0.2 * mm);
  const double reach = 0.4 * (a_root - apex).norm(), across = 0.35 * std::abs(a_root.y());
  add_bend(path, a_root, reach * (a_root - a_tip).normalized(), apex, Vec3(0, across, 0));
  path.push_back(apex);
  add_bend(path, apex, Vec3(0, across, 0), b_root, reach * (b_tip - b_root).normalized());
  path.push_back(b_root);
  path.push_back(b_tip);
  return clip_wire(path);
}

bool shows_loaded_clip(const Snapshot& snapshot, std::size_t index) {
  const InstrumentSnapshot& applier = snapshot.instruments[index];
  if (applier.kind != InstrumentKind::clip_applier) return false;
  const InstrumentGeometry geometry = instrument_geometry(applier.kind);
  if (applier.opening < 0.25 * geometry.max_opening) return false;
  const Vec3 middle = applier.pose * Vec3(0, 0, 0.75 * geometry.jaw_length);
  for (const ClipSnapshot& clip : snapshot.clips)
    if ((clip.frame.position - middle).norm() < 0.3 * geometry.jaw_length) return false;
  return true;
}

ModelPart clip_model(const ClipSnapshot& clip) {
  const RoundedPiece& a = clip.shape.pieces[0];
  const RoundedPiece& b = clip.shape.pieces[1];
  const double bend = std::min(0.5 * mm, std::abs(a.corners[0].y()));
  const Vec3 up(0, 0, bend), across(0, bend, 0);
  constexpr double round = 0.55;  // of a quarter circle as a cubic
  std::vector<Vec3> path{a.corners[1], a.corners[0] + up};
  add_bend(path, path.back(), -round * up, a.corners[0] + across, round * across);
  if (std::abs(a.corners[0].y()) > bend + 0.05 * mm) {
    path.push_back(a.corners[0] + across);
    path.push_back(b.corners[0] - across);
  } else {
    path.push_back((a.corners[0] + b.corners[0]) / 2);
  }
  add_bend(path, path.back(), round * across, b.corners[0] + up, round * up);
  path.push_back(b.corners[0] + up);
  path.push_back(b.corners[1]);
  return clip_wire(path);
}

}  // namespace calot
