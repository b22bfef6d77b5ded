#include "calot/patient/phantom_field.h"

#include <algorithm>
#include <cmath>

#include "calot/patient/phantom_tree.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr double bile_hounsfield = 3;

std::size_t nearest_point(const Curve& curve, const Vec3& p) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < curve.size(); ++i)
    if ((curve[i] - p).squaredNorm() < (curve[best] - p).squaredNorm()) best = i;
  return best;
}

/// The duct as far as it is free of the bile duct, then beside it with a gap, and into it at its point `low`.
Curve inserted_low(const Curve& usual, const Centreline& bile, double radius, std::size_t low) {
  const double beside = bile.radii[0] + radius + 1.5 * mm;
  Curve free;
  for (const Vec3& p : usual) {
    if (distance_to(bile.points, p) < beside + 2 * mm) break;
    free.push_back(p);
  }
  Curve through = resampled(free, 4 * mm);
  const std::size_t start = nearest_point(bile.points, through.back());
  const Vec3 out = through.back() - bile.points[start];
  const std::size_t step = 16;  // points of the bile duct, a quarter millimetre each
  for (std::size_t p = start + 24; p + 28 <= low; p += step) {
    const Vec3 along = (bile.points[p + 1] - bile.points[p - 1]).normalized();
    through.push_back(bile.points[p] + beside * (out - out.dot(along) * along).normalized());
  }
  through.push_back(bile.points[low]);
  return resampled(spline(through), 0.2 * mm);
}

void insert_low(Random& random, OperatingField& field, Centreline& cystic) {
  const double run = random.uniform(28, 44) * mm;  // 20 … 40 mm side by side, and the way there
  Curve& bile = field.bile_duct.points;
  const auto low = field.junction + static_cast<std::size_t>(run / (0.25 * mm));
  const Curve line = inserted_low(cystic.points, field.bile_duct, cystic.radii[0], low);
  cystic = {cystic.name, line, std::vector<double>(line.size(), cystic.radii[0])};
  const double moved = 0.25 * mm * static_cast<double>(low - field.junction);
  PhantomFacts& facts = field.facts;
  facts.hepatic_duct_length += moved;
  facts.bile_duct_length -= moved;
  facts.cystic_duct_length = visible_length(line, gallbladder_neck_radius, field.bile_duct);
  const Vec3 shift = -bile[low];  // the origin is where the ducts join
  for (Vec3& p : bile) p += shift;
  for (Vec3& p : cystic.points) p += shift;
  for (Ball& ball : field.lumen) ball.centre += shift;
  field.hub = shift;
  field.junction = low;
}

/// The wall as a region of its own: thin at the neck, thick from a quarter of the length on.
BallChain thickened(const BallChain& lumen, double thickness) {
  BallChain outside = lumen;
  for (std::size_t b = 0; b < outside.size(); ++b) {
    const double t = std::min(4.0 * static_cast<double>(b) / static_cast<double>(outside.size() - 1), 1.0);
    outside[b].radius += std::max(1.5 * mm, thickness * t * t * (3 - 2 * t));
  }
  return outside;
}

Vec3 onto_liver(const OperatingField& field, const Vec3& p) {
  return p - (std::max(field.liver.field.at(p), 0.0) + 3 * mm) * field.liver.form.down;
}

}  // namespace

const FieldTube& OperatingField::tube(Structure s) const {
  return *std::find_if(tubes.begin(), tubes.end(), [&](const FieldTube& t) { return t.structure == s; });
}

std::vector<Centreline> OperatingField::lines() const {
  std::vector<Centreline> lines;
  const FieldTube& cystic = tube(Structure::cystic_duct);
  const auto middle = static_cast<std::ptrdiff_t>(junction);
  const Curve& all = bile_duct.points;
  const Curve above(all.begin(), all.begin() + middle + 1), below(all.begin() + middle, all.end());
  const double radius = bile_duct.radii[0];
  lines.push_back(cystic.line);
  const auto add = [&](Structure s, const Curve& curve) {
    lines.push_back({std::string(name_of(s)), curve, std::vector<double>(curve.size(), radius)});
  };
  add(Structure::common_hepatic_duct, above);
  add(Structure::common_bile_duct, below);
  for (const FieldTube& t : tubes)
    if (t.structure != Structure::cystic_duct) lines.push_back(t.line);
  return lines;
}

void draw_field_ducts(std::uint64_t seed, PhantomVariant variant, Random& random, OperatingField& field) {
  Random tree(seed);
  PhantomFacts& facts = field.facts;
  field.bile_duct = draw_bile_duct(tree, facts);
  draw_cystic_duct_sizes(tree, facts);
  if (variant == PhantomVariant::short_cystic_duct) facts.cystic_duct_length = random.uniform(8, 12) * mm;
  Centreline cystic = draw_cystic_duct(tree, gallbladder_neck_radius, field.bile_duct, facts);
  field.lumen = draw_gallbladder(tree, cystic.points.front(), gallbladder_neck_radius, facts);
  Curve& bile = field.bile_duct.points;
  field.hub = Vec3::Zero();
  field.junction = nearest_point(bile, field.hub);
  bile[field.junction] = field.hub;
  if (variant == PhantomVariant::low_insertion) insert_low(random, field, cystic);
  field.junction_direction = (bile[field.junction + 4] - bile[field.junction - 4]).normalized();
  for (const Vec3& p : cystic.points) {
    field.mouth = p;
    if (distance_to(bile, p) < field.bile_duct.radii[0]) break;
  }
  if (variant == PhantomVariant::inflamed) facts.wall_thickness = random.uniform(4.2, 6.8) * mm;
  field.outside = facts.wall_thickness > 0 ? thickened(field.lumen, facts.wall_thickness) : field.lumen;
  field.tubes.push_back({Structure::cystic_duct, cystic, bile_hounsfield});
}

SampledField draw_hepatocystic_fat(Random& random, const OperatingField& field) {
  const double half = random.uniform(3.4, 4.4) * mm;
  const Curve& bile = field.bile_duct.points;
  const Vec3 junction = field.hub, hilum = bile[16];
  const Vec3 neck = field.outside.front().centre, body = field.outside[field.outside.size() / 5].centre;
  const Vec3 hilum_up = onto_liver(field, hilum), neck_up = onto_liver(field, neck), body_up = onto_liver(field, body);
  const std::array<std::array<Vec3, 3>, 5> sheets{{{junction, neck, hilum},
                                                   {neck, hilum, neck_up},
                                                   {hilum, neck_up, hilum_up},
                                                   {neck, body, neck_up},
                                                   {body, neck_up, body_up}}};
  Eigen::AlignedBox3d box;
  for (const auto& sheet : sheets)
    for (const Vec3& corner : sheet) box.extend(corner);
  std::vector<Curve> covered;
  for (const FieldTube& tube : field.tubes)
    if (tube.structure != Structure::right_hepatic_artery) {
      covered.push_back(resampled(tube.line.points, 1 * mm));
      for (const Vec3& p : covered.back()) box.extend(p);
    }
  box.min().array() -= 8 * mm;
  box.max().array() += 8 * mm;
  const double cover = 3.4 * mm;  // about a vessel's middle
  return {box, 1.5 * mm, [&](const Vec3& p) {
            double d = 1;
            for (const auto& sheet : sheets) d = smooth_min(d, distance_to_triangle(p, sheet) - half, 4 * mm);
            for (const Curve& curve : covered) d = smooth_min(d, distance_to_tube(curve, cover, p), 4 * mm);
            return d;
          }};
}

OperatingField draw_operating_field(std::uint64_t seed, PhantomVariant variant) {
  OperatingField field;
  Random random(scramble(seed) ^ 0x6669656c64u);  // a stream of its own, so that the tree's stays as it is
  draw_field_ducts(seed, variant, random, field);
  field.bed_thickness = random.uniform(2.0, 3.0) * mm;
  field.liver =
      draw_liver(random, {field.hub, &field.outside, field.bed_thickness, field.bile_duct.points[12]}, field.facts);
  draw_field_vessels(variant, random, field);
  field.fat = draw_hepatocystic_fat(random, field);
  return field;
}

}  // namespace calot
