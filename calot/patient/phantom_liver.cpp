#include "calot/patient/phantom_liver.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "calot/base/error.h"
#include "calot/patient/phantom_tree.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr double cava_radius = 11 * mm, fissure_radius = 5 * mm;

/// What is to be met.
struct Wanted {
  double volume, width, depth, height;
  double overhang;  ///< of the gallbladder's fundus beyond the liver's edge
};

/// What is turned to meet it: places of the outermost points about the hub, and how boxy the dome is.
struct Knobs {
  double left = -94 * mm, top = 94 * mm, back = -46 * mm, front = 68 * mm, power = 2.4;
};

Wanted draw_wanted(Random& random) {
  Wanted wanted{};
  do wanted.volume = (1281 + 219 * random.normal()) * 1e-6;  // as far as the extents' ranges go
  while (wanted.volume < 1070e-6 || wanted.volume > 1510e-6);
  const double scale = std::cbrt(wanted.volume / 1281e-6);
  wanted.width = std::clamp(212.5 * scale * random.uniform(0.99, 1.01), 202.0, 223.0) * mm;
  wanted.height = std::clamp(162.5 * scale * random.uniform(0.99, 1.01), 152.0, 173.0) * mm;
  wanted.depth = std::clamp(113.0 * scale * random.uniform(0.99, 1.01), 102.0, 123.0) * mm;
  wanted.overhang = random.uniform(2, 9) * mm;
  return wanted;
}

/// The body between two corners.
Superellipsoid between(const Vec3& low, const Vec3& high, double power) {
  return {(low + high) / 2, (high - low) / 2, power};
}

void turn(LiverForm& form, const Knobs& k, const Vec3& hub) {
  const Vec3 low(-16 * mm, k.back, -78 * mm), high(110 * mm, k.front, k.top);
  form.right = between(hub + low, hub + high, k.power);
  const Vec3 left_low(k.left, k.front - 74 * mm, 8 * mm), left_high(60 * mm, k.front - 2 * mm, k.top - 24 * mm);
  form.left = between(hub + left_low, hub + left_high, k.power);
  form.caudate.centre[1] = hub[1] + std::max(-17 * mm, k.back + 20 * mm);
}

/// The visceral surface passes a finger's breadth above the gallbladder's neck and cuts into its body, so that a third
/// to a half of the circumference lies in the bed.
void lay_sheet(Random& random, const LiverAnchors& anchors, LiverForm& form) {
  const BallChain& balls = *anchors.gallbladder;
  const Ball& body = balls[balls.size() * 3 / 4];
  const Vec3 neck = balls.front().centre;
  const Vec3 axis = (body.centre - neck).normalized();
  const Vec3 wish = vary(random, {-0.36, -0.57, -0.74}, 0.06);
  const Vec3 down = (wish - wish.dot(axis) * axis).normalized();
  const Vec3 above_neck = neck - random.uniform(7.5, 9.5) * mm * down;
  form.sheet_point = body.centre - random.uniform(0.22, 0.38) * body.radius * down;
  const Vec3 along = (form.sheet_point - above_neck).normalized();
  form.down = (down - down.dot(along) * along).normalized();
  form.across = form.down.cross(along);
  form.bend_from = 0.6 * (form.sheet_point - above_neck).norm();
  form.drop_right = random.uniform(24, 32) * mm;
  form.drop_left = random.uniform(10, 16) * mm;
}

LiverForm first_form(Random& random, const LiverAnchors& anchors) {
  LiverForm form;
  lay_sheet(random, anchors, form);
  const Vec3& hub = anchors.hub;
  const Vec3 caudate(-12 + random.uniform(-2, 2), -17, 46 + random.uniform(-3, 3));
  form.caudate = {hub + caudate * mm, Vec3(17, 12, 19) * mm, 2};
  form.cava = {hub + Vec3(-9, -31, -120) * mm, hub + Vec3(-9, -31, 140) * mm};
  form.hilum = anchors.hilum;
  return form;
}

/// After the sheet and the dome are known: the fissure runs on the visceral surface from the hilum's left end forwards.
void mark_hilum(LiverForm& form, const Knobs& knobs, const LiverAnchors& anchors) {
  form.fissure.clear();
  form.hilum_shift = form.bend = 0;
  const double gap = form.distance(form.hilum);
  const double behind = (form.hilum - form.sheet_point).dot(form.across.cross(form.down)) + form.bend_from;
  if (behind < 0) form.bend = std::max(gap, 0.0) / (behind * behind);
  form.hilum_shift = -form.distance(form.hilum);
  const auto on_surface = [&](const Vec3& p) {  // from the sheet down to where the liver ends
    Vec3 q = p - (p - form.sheet_point).dot(form.down) * form.down;
    for (int step = 0; step < 60 && form.distance(q) < 0; ++step) q += mm * form.down;
    return q;
  };
  const Vec3 from = anchors.hub + Vec3(-24 * mm, 6 * mm, 36 * mm);
  const Vec3 to = anchors.hub + Vec3(-38 * mm, knobs.front + 8 * mm, 20 * mm);
  Curve fissure;
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) fissure.push_back(on_surface(from + share * (to - from)));
  form.fissure = fissure;
}

/// How far the fundus reaches beyond the liver's edge, seen along the gallbladder.
double overhang(const LiverForm& form, const LiverAnchors& anchors) {
  const BallChain& balls = *anchors.gallbladder;
  const Vec3 along = form.across.cross(form.down);
  const Vec3 start = form.sheet_point - 4 * mm * form.down;
  double edge = -20 * mm;
  while (edge < 120 * mm && form.distance(start + edge * along) < 0) edge += 0.5 * mm;
  return (balls.back().centre - start).dot(along) + balls.back().radius - edge;
}

/// `liver` with the fossa taken out.
SampledField carved(const std::function<double(const Vec3&)>& liver, const LiverAnchors& anchors, double step) {
  Eigen::AlignedBox3d near = bounds(*anchors.gallbladder);
  near.min().array() -= anchors.bed_thickness;
  near.max().array() += anchors.bed_thickness;
  const Eigen::AlignedBox3d box(anchors.hub + Vec3(-135, -80, -105) * mm, anchors.hub + Vec3(140, 125, 130) * mm);
  return {box, step, [&](const Vec3& p) {
            const double d = liver(p);
            if (!near.contains(p)) return d;
            return std::max(d, anchors.bed_thickness - distance_to(*anchors.gallbladder, p));
          }};
}

/// Turns the extents' knobs until they are met; the volume then is what `power` makes it.
double fit_extents(LiverForm& form, Knobs& knobs, const LiverAnchors& anchors, const Wanted& wanted, int rounds) {
  double volume = 0;
  for (int round = 0; round < rounds; ++round) {
    turn(form, knobs, anchors.hub);
    mark_hilum(form, knobs, anchors);
    const SampledField::Measure m =
        carved([&](const Vec3& p) { return form.distance(p); }, anchors, 10 * mm).measure_inside();
    const Vec3 size = m.extent.sizes();
    volume = m.volume;
    const double forward = 0.6 * (overhang(form, anchors) - wanted.overhang);
    knobs.left -= wanted.width - size[0];
    knobs.top += wanted.height - size[2];
    knobs.front += forward;
    knobs.back += forward - (wanted.depth - size[1]);
  }
  return volume;
}

/// Finds the dome that has the volume, its extents kept.
void fit(LiverForm& form, const LiverAnchors& anchors, const Wanted& wanted) {
  Knobs knobs;
  double low = 1.7, high = 4.5;
  for (int step = 0; step < 8; ++step) {
    knobs.power = (low + high) / 2;
    const double volume = fit_extents(form, knobs, anchors, wanted, step == 0 ? 4 : 2);
    (volume < wanted.volume ? low : high) = knobs.power;
  }
}

}  // namespace

double LiverForm::dome(const Vec3& p) const {
  return smooth_min(right.distance(p), left.distance(p), 25 * mm);
}

double LiverForm::distance(const Vec3& p) const {
  const Vec3 q = p - sheet_point;
  const double b = q.dot(across), wide = 42 * mm;
  const double drop = (b > 0 ? drop_right : drop_left) * b * b / (b * b + wide * wide);
  const double behind = std::min(q.dot(across.cross(down)) + bend_from, 0.0);
  const double dip = bend * behind * behind / (1 + b * b / (45 * mm * 45 * mm));
  const double below = q.dot(down) - drop - dip;
  if (below > 40 * mm) return below;  // far outside: the dome needn't be known
  double d = smooth_max(dome(p), below, 7 * mm);
  d = smooth_min(d, caudate.distance(p), 10 * mm);
  const double far = std::min((p - hilum).norm() / (30 * mm), 1.0), near = 1 - far * far;
  d += hilum_shift * near * near;
  if (!fissure.empty()) d = smooth_max(d, fissure_radius - distance_to(fissure, p), 5 * mm);
  return smooth_max(d, cava_radius - distance_to(cava, p), 3 * mm);
}

Liver draw_liver(Random& random, const LiverAnchors& anchors, PhantomFacts& facts) {
  for (int attempt = 0; attempt < 12; ++attempt) {  // about one in a hundred can't be had around its gallbladder
    const Wanted wanted = draw_wanted(random);
    Liver liver{first_form(random, anchors), {}};
    fit(liver.form, anchors, wanted);
    const Eigen::AlignedBox3d box(anchors.hub + Vec3(-135, -80, -105) * mm, anchors.hub + Vec3(140, 125, 130) * mm);
    liver.field = SampledField(box, 2.5 * mm, [&](const Vec3& p) { return liver.form.distance(p); });
    const SampledField::Measure m =
        carved([&](const Vec3& p) { return liver.field.at(p); }, anchors, 3 * mm).measure_inside();
    const Vec3 size = m.extent.sizes(), missed = size - Vec3(wanted.width, wanted.depth, wanted.height);
    if (!(std::abs(m.volume / wanted.volume - 1) < 0.015) || !(missed.cwiseAbs().maxCoeff() < 2 * mm)) continue;
    facts.liver_volume = m.volume;
    facts.liver_width = size[0], facts.liver_depth = size[1], facts.liver_height = size[2];
    return liver;
  }
  throw FailedError("phantom", "found no liver within the published ranges", "try another seed");
}

}  // namespace calot
