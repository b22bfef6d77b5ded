// Grasper, forceps and clip applier.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calot/view/models/pieces.h"

namespace calot::detail {
namespace {

constexpr double mm = model_mm;
constexpr double slot = 0.98 * mm;    // half of the joint's slot
constexpr double cheek = 1.30 * mm;   // the outside of its cheeks
constexpr double insulated = 3 * mm;  // the tube ends this far before its round end begins

Parts shaft_with_joint(const InstrumentGeometry& geometry) {
  const Tube tube = tube_of(geometry);
  Parts parts{insulated_tube(tube, tube.shoulder - insulated)};
  add_clevis(parts, tube, tube.shoulder - insulated - 0.3 * mm, slot, cheek);
  return parts;
}

void add_jaws(Parts& parts, const PlainMesh& a, const PlainMesh& b, ModelMaterial material,
              double crease = usual_crease) {
  parts.push_back(finish(a, ModelFrame::jaw_a, material, crease, grain_along_z));
  parts.push_back(finish(b, ModelFrame::jaw_b, material, crease, grain_along_z));
}

/// The arm from the pin to where the face begins, as deep as the simulation's stem; from z = −0.5 mm to its end.
std::vector<Ring> stem_rings(double radius, double narrow, double until) {
  std::vector<Ring> rings;
  const auto add = [&](double z, double width, double depth) {
    const double top = radius * (1 - depth);
    rings.push_back(ring_at(jaw_section(width, 2 * radius * depth, 0.7 * width, 0.02 * mm), Vec3(0, -top, z)));
  };
  add(-0.55 * mm, 0.8 * narrow, 0.62);
  add(-0.2 * mm, narrow, 0.86);
  add(0.4 * mm, narrow, 0.94);
  add(1.15 * mm, narrow, 0.95);
  add(1.45 * mm, 0.96 * radius, 0.97);
  add(until, 0.97 * radius, 0.97);
  return rings;
}

// --- bowel grasper ---

/// A place on the frame around the window: its outer and its inner border, and how deep teeth are cut there.
struct FramePlace {
  Eigen::Vector2d outer, inner;  // x, z
  double tooth = 0;
};

struct Window {
  double half_width = 0, low = 0, high = 0, corner = 0;
};

Eigen::Vector2d on_corner(const Window& w, int quarter, double share) {
  const double sx = quarter == 0 || quarter == 3 ? 1 : -1, sz = quarter < 2 ? 1 : -1;
  const double angle = std::numbers::pi / 2 * (quarter + share);
  return {sx * (w.half_width - w.corner) + w.corner * std::cos(angle),
          (sz > 0 ? w.high - w.corner : w.low + w.corner) + w.corner * std::sin(angle)};
}

/// Once around, beginning at the foot of the rail at +x; teeth on rails and tip.
std::vector<FramePlace> frame_places(const Window& outer, const Window& inner, double depth, bool shifted) {
  std::vector<FramePlace> places;
  constexpr double pitch = 0.8 * mm, foot_corner = 1.5 * mm;
  const auto rail = [&](double side, double from, double to) {
    const int count = 2 * static_cast<int>(std::abs(to - from) / pitch);
    for (int k = 0; k <= count; ++k) {
      const double z = from + (to - from) * k / count;
      const bool low = (k % 2 == 0) != shifted;
      places.push_back({{side * outer.half_width, z},
                        {side * inner.half_width, z},
                        k == 0 || k == count ? depth / 2 : (low ? depth : 0)});
    }
  };
  const auto corner = [&](int quarter) {
    constexpr int steps = 6;
    for (int k = 0; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      Window rounded = outer;
      if (quarter >= 2) rounded.corner = foot_corner;
      places.push_back({on_corner(rounded, quarter, share), on_corner(inner, quarter, share), depth / 2});
    }
  };
  const double foot = inner.low + inner.corner + 0.2 * mm, head = inner.high - inner.corner - 0.2 * mm;
  rail(1, foot, head);
  corner(0);
  for (int k = 1; k < 6; ++k) {
    const double x = 1 - 2.0 * k / 6;
    places.push_back({{x * (outer.half_width - outer.corner), outer.high},
                      {x * (inner.half_width - inner.corner), inner.high},
                      (k % 2 == 0) != shifted ? depth : 0});
  }
  corner(1);
  rail(-1, head, foot);
  corner(2);
  corner(3);
  return places;
}

PlainMesh window_jaw(const InstrumentGeometry& g, bool shifted) {
  const double r = (g.jaw_width - 2 * 0.9 * mm) / 4;
  const Window outer{g.jaw_width / 2, g.face_start - r, g.jaw_length, 1.25 * mm};
  const Window inner{g.jaw_width / 2 - 2 * r, g.face_start + r, g.jaw_length - 2 * r, 0.5 * mm};
  std::vector<Ring> rings;
  for (const FramePlace& place : frame_places(outer, inner, 0.22 * mm, shifted)) {
    const Eigen::Vector2d middle = (place.outer + place.inner) / 2, half = (place.outer - place.inner) / 2;
    const double along = (middle.y() - outer.low) / (outer.high - outer.low);
    const double depth = (1.74 - 0.3 * along) * mm;  // slimmer towards the tip
    const std::array<Eigen::Vector2d, 11> outline{{{0.66, -place.tooth},
                                                   {0, -place.tooth},
                                                   {-0.66, -place.tooth},
                                                   {-1, -0.24 * depth},
                                                   {-1, -0.7 * depth},
                                                   {-0.86, -0.86 * depth},
                                                   {-0.6, -depth},
                                                   {0.6, -depth},
                                                   {0.86, -0.86 * depth},
                                                   {1, -0.7 * depth},
                                                   {1, -0.24 * depth}}};
    Ring ring;
    for (const Eigen::Vector2d& p : outline)
      ring.emplace_back(middle.x() + p.x() * half.x(), p.y(), middle.y() + p.x() * half.y());
    rings.push_back(std::move(ring));
  }
  PlainMesh mesh;
  add_closed_loft(mesh, rings);
  set_openness(mesh, 0, [&](const Vec3& p) { return std::abs(p.x()) < inner.half_width + 0.1 * mm ? 0.75 : 1.0; });
  return mesh;
}

// --- curved forceps ---

PlainMesh curved_jaw(const InstrumentGeometry& g, bool shifted) {
  std::vector<Ring> rings = stem_rings(g.jaw_width / 2, 0.94 * mm, g.face_start - 0.4 * mm);
  const double tip = g.jaw_length - g.tip_width / 2, lead = (tip - g.face_start) / 8;
  const auto radius = [&](double z) { return g.width(std::min(z + lead, tip)) / 2; };
  const auto add = [&](double z, double share, double tooth) {
    const double r = radius(z) * share;
    rings.push_back(
        ring_at(jaw_section(r, 2 * r, 0.6 * r, tooth), Vec3(g.middle(z), share < 1 ? r - radius(z) : 0, z)));
  };
  constexpr double pitch = 0.7 * mm;
  const double from = g.face_start + 0.6 * mm, to = tip - 0.3 * mm;
  const int count = 2 * static_cast<int>((to - from) / pitch);
  add(g.face_start + 0.2 * mm, 1, 0.02 * mm);
  for (int k = 0; k <= count; ++k) add(from + (to - from) * k / count, 1, ((k % 2 == 0) != shifted ? 0.17 : 0.02) * mm);
  for (const double angle : {0.0, 0.4, 0.75, 1.05, 1.3})
    add(tip + std::sin(angle) * g.tip_width / 2, std::max(0.2, std::cos(angle) * 0.98), 0.03 * mm);
  PlainMesh mesh;
  add_loft(mesh, rings);
  return mesh;
}

// --- clip applier ---

/// Flat face with the channel that a clip's leg lies in.
Outline channel_section(double half_width, double depth, double channel, double channel_depth) {
  Outline outline = jaw_section(half_width, depth, 0.78 * half_width, 0);
  outline.erase(outline.begin() + 1);
  outline.insert(outline.begin() + 1,
                 {{channel, 0}, {0.92 * channel, -channel_depth}, {-0.92 * channel, -channel_depth}, {-channel, 0}});
  return outline;
}

PlainMesh channel_jaw(const InstrumentGeometry& g) {
  const double r = g.jaw_width / 2, tip = g.jaw_length - r;
  std::vector<Ring> rings;
  const auto add = [&](double z, double width, double depth, double channel) {
    rings.push_back(ring_at(channel_section(width, 2 * r * depth, 0.55 * mm * std::min(1.0, width / r), channel),
                            Vec3(0, -r * (1 - depth), z)));
  };
  add(-0.55 * mm, 0.7 * mm, 0.6, 0.01 * mm);
  add(-0.2 * mm, 0.92 * mm, 0.86, 0.01 * mm);
  add(1.15 * mm, 0.94 * mm, 0.95, 0.01 * mm);
  add(1.5 * mm, 0.97 * r, 0.97, 0.01 * mm);
  add(3.4 * mm, 0.98 * r, 0.98, 0.01 * mm);
  add(3.7 * mm, 0.98 * r, 0.98, 0.27 * mm);
  add(tip, 0.98 * r, 0.98, 0.27 * mm);
  for (const double angle : {0.4, 0.75, 1.05})
    add(tip + r * std::sin(angle), r * std::cos(angle), std::max(0.5, std::cos(angle)), 0.2 * mm * std::cos(angle));
  PlainMesh mesh;
  add_loft(mesh, rings);
  set_openness(mesh, 0, [&](const Vec3& p) {
    return std::abs(p.x()) < 0.53 * mm && p.y() < -0.2 * mm && p.y() > -0.4 * mm && p.z() > 3.6 * mm ? 0.5 : 1.0;
  });
  return mesh;
}

}  // namespace

Parts bowel_grasper_model(const InstrumentGeometry& g) {
  Parts parts = shaft_with_joint(g);
  const auto jaw = [&](bool shifted, double low, double high) {
    PlainMesh mesh = window_jaw(g, shifted);
    std::vector<Ring> rings = stem_rings(1.2 * mm, 0.92 * mm, 3.2 * mm);
    const auto nose = [&](double z, double share) {
      rings.push_back(ring_at(jaw_section(1.17 * share * mm, 2.3 * share * mm, 0.8 * share * mm, 0.02 * mm),
                              Vec3(0, -1.2 * (1 - share) * mm, z)));
    };
    nose(3.7 * mm, 0.9);
    nose(4.05 * mm, 0.6);
    add_loft(mesh, rings);
    add_eye(mesh, 1.2 * mm, low, high);
    return mesh;
  };
  add_jaws(parts, jaw(false, -0.95 * mm, -0.03 * mm), mirrored_in_y(jaw(true, 0.03 * mm, 0.95 * mm)),
           ModelMaterial::brushed_steel, 0.4);
  return parts;
}

Parts curved_forceps_model(const InstrumentGeometry& g) {
  Parts parts = shaft_with_joint(g);
  PlainMesh a = curved_jaw(g, false), b = curved_jaw(g, true);
  add_eye(a, 1.2 * mm, -0.95 * mm, -0.03 * mm);
  add_eye(b, 1.2 * mm, 0.03 * mm, 0.95 * mm);
  add_jaws(parts, a, mirrored_in_y(b), ModelMaterial::polished_steel);
  return parts;
}

Parts clip_applier_model(const InstrumentGeometry& g) {
  Parts parts = shaft_with_joint(g);
  PlainMesh a = channel_jaw(g), b = a;
  add_eye(a, 1.2 * mm, -0.95 * mm, -0.03 * mm);
  add_eye(b, 1.2 * mm, 0.03 * mm, 0.95 * mm);
  add_jaws(parts, a, mirrored_in_y(b), ModelMaterial::brushed_steel);
  return parts;
}

}  // namespace calot::detail
