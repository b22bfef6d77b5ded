#include "calot/patient/phantom_abdomen.h"

#include <algorithm>
#include <cmath>

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr double midline = -28 * mm;  ///< of the body, from the hub

// HU of textbooks, our choice within their ranges.
namespace hu {
constexpr float air = -1000, lung = -850, gas = -950, skin = 30, subcutaneous = -100, visceral_fat = -95, muscle = 55;
constexpr float spongy_bone = 180, compact_bone = 450, disc = 80, spinal_canal = 25, kidney = 32, spleen = 50;
constexpr float pancreas = 40, blood = 41, bowel = 30, stomach = 20, heart = 42, psoas = 55;
}  // namespace hu

float share_inside(double distance, double voxel) {
  return static_cast<float>(std::clamp(0.5 - distance / voxel, 0.0, 1.0));
}

void blend(float& value, float with, float share) {
  value += share * (with - value);
}

Filled ellipsoid(const Vec3& centre_mm, const Vec3& radii_mm, double hounsfield, double power = 2) {
  return {Filled::Kind::ellipsoid, {centre_mm * mm, radii_mm * mm, power}, {}, 0, hounsfield};
}

Filled tube(const std::vector<Vec3>& through_mm, double radius_mm, double hounsfield) {
  Curve curve = resampled(spline(through_mm), 2.0);
  for (Vec3& p : curve) p *= mm;
  return {Filled::Kind::tube, {}, curve, radius_mm * mm, hounsfield};
}

/// From the hub, in millimetres. Later ones win.
std::vector<Filled> bodies_at_hub(Random& random, double front) {
  const auto w = [&] { return random.uniform(-2, 2); };
  const double left = 1e3 * midline;
  std::vector<Filled> bodies{
      ellipsoid({left - 22, front - 42, 132 + w()}, {58, 40, 42}, hu::heart),
      ellipsoid({left - 98 + w(), -48, 42 + w()}, {26, 42, 52}, hu::spleen),
      ellipsoid({left + 62 + w(), -72, -42 + w()}, {27, 25, 54}, hu::kidney),
      ellipsoid({left + 54, -68, -42}, {12, 9, 26}, hu::visceral_fat),
      ellipsoid({left - 62 + w(), -74, -30 + w()}, {27, 25, 54}, hu::kidney),
      ellipsoid({left - 54, -70, -30}, {12, 9, 26}, hu::visceral_fat),
      tube({{left - 12, -37, -130}, {left - 12, -36, 0}, {left - 14, -42, 150}}, 10, hu::blood),  // aorta
      tube({{-10, -31, -130}, {-9, -31, 60}, {-9, -29, 150}}, 10.5, hu::blood),                   // vena cava
      tube({{left - 10, -22, -60}, {-24, -18, -35}, {-14, -14, -5}, {-2, -11, 22}, {6, -8, 36}}, 6,
           hu::blood),                                                             // portal
      tube({{left - 12, -30, 8}, {-42, -14, 10}, {-27, -3, -5}}, 2.6, hu::blood),  // common hepatic artery
      ellipsoid({-6, -3, -46}, {18, 15, 28}, hu::pancreas),
      tube({{-14, -4, -40}, {-45, 2, -22}, {-80, -18, 5}, {-110, -40, 24}}, 9, hu::pancreas)};
  bodies.push_back(tube({{-66, 34, -22}, {-36, 32, -30}, {-4, 22, -20}}, 13, 38));  // antrum
  Filled stomach = tube({{-70, -16, 58}, {-98, 0, 48}, {-102, 18, 12}, {-74, 32, -18}}, 21, hu::stomach);
  stomach.gas_above = 31 * mm;
  Filled stomach_wall = stomach;
  stomach_wall.radius += 4 * mm, stomach_wall.hounsfield = 45, stomach_wall.gas_above = 1e9;
  bodies.push_back(stomach_wall);
  bodies.push_back(stomach);
  bodies.push_back(tube(
      {{-2, 18, -22}, {14, 8, -22}, {24, -8, -34}, {24, -18, -62}, {16, -22, -84}, {-10, -20, -92}, {-60, -14, -88}},
      11, hu::bowel));
  Filled colon = tube({{72, -38, -130},
                       {74, -30, -100},
                       {68, 0, -88},
                       {40, front - 45, -96},
                       {-20, front - 36, -98},
                       {-80, front - 40, -84},
                       {-118, -20, -48},
                       {-122, -46, -130}},
                      17, hu::bowel);
  colon.gas_above = (front - 42) * mm;
  bodies.push_back(colon);
  for (int loop = 0; loop < 6; ++loop) {
    const double x = -20 - 16 * loop + 3 * w(), z = -112 + 6 * w();
    bodies.push_back(
        tube({{x + 20, 10 + 5 * w(), z}, {x, 22 + 6 * w(), z + 14}, {x - 18, -4 + 5 * w(), z}}, 10 + w(), hu::bowel));
  }
  return bodies;
}

/// Grows the trunk until liver and gallbladder lie behind its wall.
Trunk trunk_around(Random& random, const OperatingField& field) {
  Trunk trunk;
  trunk.x = field.hub[0] + midline;
  trunk.fat = random.uniform(10, 18) * mm;
  trunk.muscle = random.uniform(9, 13) * mm;
  const double back = field.hub[1] - random.uniform(128, 134) * mm;
  double front = field.hub[1] + 80 * mm;
  const double needed = trunk.fat + trunk.muscle + 2 * mm;
  const SampledField& liver = field.liver.field;
  for (int round = 0; round < 60; ++round) {
    trunk.y = (front + back) / 2, trunk.half_depth = (front - back) / 2;
    double lateral = 1, frontal = 1;  // how deep the shallowest points lie, beyond what is needed
    const auto consider = [&](const Vec3& p, double reach) {
      const double spare = -trunk.distance(p[0], p[1]) - reach - needed;
      double& least = p[1] < trunk.y + 0.35 * trunk.half_depth ? lateral : frontal;
      least = std::min(least, spare);
    };
    for (std::size_t k = 0; k < liver.size()[2]; k += 3)
      for (std::size_t j = 0; j < liver.size()[1]; j += 2)
        for (std::size_t i = 0; i < liver.size()[0]; i += 2)
          if (liver.value(i, j, k) < 0 && liver.value(i, j, k) > -8 * mm) consider(liver.place(i, j, k), 0);
    for (const Ball& ball : field.outside) consider(ball.centre, ball.radius);
    if (lateral >= 0 && frontal >= 0) break;
    trunk.half_width += std::max(0.0, -lateral) * 0.7;
    front += std::max(0.0, -frontal);
  }
  return trunk;
}

/// The diaphragm: the abdomen reaches a few millimetres beyond the liver, and as high on the left under a dome of its
/// own.
SampledField draw_dome(const OperatingField& field, const Trunk& trunk) {
  Superellipsoid right = field.liver.form.right, left = field.liver.form.left;
  right.radii.array() += 4 * mm;
  left.radii.array() += 4 * mm;
  const Vec3& hub = field.hub;
  const double top = right.centre[2] + right.radii[2];
  const Superellipsoid stomach_side{Vec3(trunk.x - 78 * mm, trunk.y + 2 * mm, hub[2] + 5 * mm),
                                    Vec3(76 * mm, 90 * mm, top - hub[2] - 20 * mm), 2.2};
  const Eigen::AlignedBox3d box(Vec3(trunk.x - trunk.half_width, trunk.y - trunk.half_depth, hub[2] - 30 * mm),
                                Vec3(trunk.x + trunk.half_width, trunk.y + trunk.half_depth, top + 60 * mm));
  const Superellipsoid crura{Vec3(trunk.x + 8 * mm, hub[1] - 38 * mm, hub[2]), Vec3(48 * mm, 34 * mm, 88 * mm), 2.5};
  Superellipsoid caudate = field.liver.form.caudate;
  caudate.radii.array() += 6 * mm;
  return {box, 6 * mm, [&](const Vec3& p) {
            // The recesses of the chest end at the hub's height, in front well above it.
            const double front = std::clamp((p[1] - trunk.y) / trunk.half_depth, 0.0, 0.8) / 0.8;
            const double floor = p[2] - hub[2] - 5 * mm - 60 * mm * front;
            const double liver = smooth_min(right.distance(p), left.distance(p), 25 * mm);
            const double behind = smooth_min(crura.distance(p), caudate.distance(p), 30 * mm);
            const double domes = smooth_min(smooth_min(liver, stomach_side.distance(p), 25 * mm), behind, 12 * mm);
            return smooth_min(domes, floor, 15 * mm);
          }};
}

}  // namespace

Eigen::AlignedBox3d Filled::box() const {
  Eigen::AlignedBox3d box;
  if (kind == Kind::ellipsoid) {
    box.extend(Vec3(ellipsoid.centre - ellipsoid.radii));
    box.extend(Vec3(ellipsoid.centre + ellipsoid.radii));
    return box;
  }
  for (const Vec3& p : curve) box.extend(p);
  box.min().array() -= radius;
  box.max().array() += radius;
  return box;
}

double Filled::distance(const Vec3& p) const {
  return kind == Kind::ellipsoid ? ellipsoid.distance(p) : distance_to_tube(curve, radius, p);
}

double Trunk::distance(double px, double py) const {
  const double a = std::abs(px - x) / half_width, b = std::abs(py - y) / half_depth, power = 2.4;
  const double ap = std::pow(a, power - 1), bp = std::pow(b, power - 1), sum = ap * a + bp * b;
  if (sum < 1e-9) return -half_depth;
  const double slope = std::pow(sum, 1 / power - 1) * std::hypot(ap / half_width, bp / half_depth);
  return (std::pow(sum, 1 / power) - 1) / slope;
}

Abdomen draw_abdomen(Random& random, const OperatingField& field) {
  Abdomen abdomen;
  abdomen.trunk = trunk_around(random, field);
  abdomen.spine_y = field.hub[1] - 62 * mm;
  abdomen.dome = draw_dome(field, abdomen.trunk);
  const double inner = abdomen.trunk.fat + abdomen.trunk.muscle;
  const double front = abdomen.trunk.y + abdomen.trunk.half_depth - inner - field.hub[1];
  abdomen.bodies = bodies_at_hub(random, front * 1e3);
  for (Filled& body : abdomen.bodies) {
    body.ellipsoid.centre += field.hub;
    for (Vec3& p : body.curve) p += field.hub;
    body.gas_above += field.hub[1];
  }
  return abdomen;
}

AbdomenPainter::AbdomenPainter(const Abdomen& abdomen, const Vec3& hub, const VoxelGrid& grid)
    : abdomen_(abdomen), hub_(hub), grid_(grid), voxel_(std::cbrt(grid.voxel_volume())) {
  const Trunk& trunk = abdomen.trunk;
  columns_.resize(grid.size[0] * grid.size[1]);
  for (std::size_t v = 0; v < columns_.size(); ++v) {
    const Vec3 p =
        grid.to_world * Vec3(static_cast<double>(v % grid.size[0]), static_cast<double>(v / grid.size[0]), 0);
    const double x = p[0] - trunk.x, y = p[1] - trunk.y;
    const double front = std::clamp(y / trunk.half_depth, -1.0, 1.0),
                 side = std::min(std::abs(x) / trunk.half_width, 1.0);
    Column& c = columns_[v];
    c.depth = static_cast<float>(-trunk.distance(p[0], p[1]));
    c.fat = static_cast<float>(trunk.fat * (1 + 0.25 * side * (0.65 - 0.35 * front)));
    c.wall =
        c.fat + static_cast<float>(trunk.muscle * (1 - 0.6 * std::max(front, 0.0) * std::exp(-x * x / (64 * mm * mm))) +
                                   std::max(-front - 0.35, 0.0) * 22 * mm);
    c.rib = static_cast<float>(hub[2] + 20 * mm - 55 * mm * front);  // ribs descend to the front
    c.margin = static_cast<float>(hub[2] + (front > 0 ? -60 + 130 * front * (1 - side * side) : -60.0) * mm);
  }
}

void AbdomenPainter::paint_layers(std::size_t k, std::span<float> hounsfield) const {
  const double z = grid_.to_world.translation()[2] + static_cast<double>(k) * grid_.spacing()[2];
  const Window all{{0, 0}, {grid_.size[0], grid_.size[1]}};
  std::vector<float> dome(columns_.size());
  abdomen_.dome.fill(grid_, k, all, dome);
  constexpr double pitch = 27 * mm, rib_radius = 5 * mm;
  for (std::size_t v = 0; v < columns_.size(); ++v) {
    const Column& c = columns_[v];
    float& value = hounsfield[v];
    value = hu::air;
    if (c.depth < -voxel_) continue;
    blend(value, hu::skin, share_inside(-c.depth, voxel_));
    blend(value, hu::subcutaneous, share_inside(2 * mm - c.depth, voxel_));
    if (c.depth < c.fat - voxel_) continue;
    blend(value, hu::muscle, share_inside(c.fat - c.depth, voxel_));
    if (c.depth < c.wall + 8 * mm && z > c.margin) {
      const double up = std::remainder(z - c.rib, pitch), in = c.depth - c.fat - 6 * mm;
      const double rib = std::hypot(up, in) - rib_radius;
      blend(value, hu::compact_bone, share_inside(rib, voxel_));
      blend(value, hu::spongy_bone, share_inside(rib + 2 * mm, voxel_));
    }
    if (c.depth < c.wall - voxel_) continue;
    const float inside = share_inside(c.wall - c.depth, voxel_), d = dome[v];
    float content = hu::visceral_fat;
    blend(content, hu::muscle, share_inside(-d, voxel_));  // the diaphragm, 3 mm
    blend(content, hu::lung, share_inside(3 * mm - d, voxel_));
    blend(value, content, inside);
  }
}

void AbdomenPainter::paint_spine(std::size_t k, std::span<float> hounsfield) const {
  const Vec3 middle(abdomen_.trunk.x, abdomen_.spine_y, 0);
  const double z = grid_.to_world.translation()[2] + static_cast<double>(k) * grid_.spacing()[2];
  const double level = std::remainder(z - hub_[2] - 4 * mm, 35 * mm);  // from the middle of a vertebra
  const double end_plate = std::abs(level) - 14 * mm;                  // beyond: disc
  Eigen::AlignedBox3d box(middle - Vec3(70, 75, 1e4) * mm, middle + Vec3(70, 30, 1e4) * mm);
  const Window window = window_of(grid_, k, box);
  const auto put = [&](float& value, float with, double distance) {
    blend(value, with, share_inside(distance, voxel_));
  };
  for (std::size_t j = window.first[1]; j < window.last[1]; ++j)
    for (std::size_t i = window.first[0]; i < window.last[0]; ++i) {
      const Vec3 p =
          grid_.to_world * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) - middle;
      const double x = std::abs(p[0]), y = p[1];
      float& value = hounsfield[i + grid_.size[0] * j];
      put(value, hu::psoas, std::hypot((x - 34 * mm) / 1.0, (y + 4 * mm) / 1.3) - 13 * mm);
      put(value, hu::muscle, std::hypot((x - 30 * mm) / 1.3, (y + 48 * mm) / 1.0) - 19 * mm);
      const double body = (std::hypot(x / (22 * mm), y / (17 * mm)) - 1) * 18 * mm;
      const double arch = std::abs(std::hypot(x, y + 26 * mm) - 11.5 * mm) - 3 * mm;
      const double process = std::max(x - 3 * mm, std::abs(y + 47 * mm) - 12 * mm);
      const double wing = std::max(std::abs(y + 27 * mm + 0.25 * x) - 4 * mm, x - 38 * mm);
      const double low = std::abs(level + 3 * mm) - 9 * mm;  // processes don't fill the whole height
      const double bone = std::min({body, arch, std::max(std::min(process, wing), low)});
      put(value, hu::compact_bone, bone);
      put(value, hu::spongy_bone, bone + 2 * mm);
      put(value, hu::disc, std::max(body, -end_plate));
      put(value, hu::spinal_canal, std::hypot(x, y + 26 * mm) - 9 * mm);
    }
}

void AbdomenPainter::paint(std::size_t k, std::span<float> hounsfield) const {
  paint_layers(k, hounsfield);
  paint_spine(k, hounsfield);
  for (const Filled& body : abdomen_.bodies) {
    Eigen::AlignedBox3d box = body.box();
    box.min().array() -= voxel_;
    box.max().array() += voxel_;
    const Window window = window_of(grid_, k, box);
    if (window.empty()) continue;
    std::vector<float> distance(window.count(), static_cast<float>(voxel_));
    const VoxelGrid part = grid_of(grid_, window);
    if (body.kind == Filled::Kind::tube)
      lower_to_distance(balls_along(body.curve, std::vector<double>(body.curve.size(), body.radius)), part, k, voxel_,
                        distance);
    for (std::size_t v = 0; v < distance.size(); ++v) {
      const std::size_t i = v % part.size[0], j = v / part.size[0];
      const Vec3 p = part.to_world * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
      if (body.kind == Filled::Kind::ellipsoid) distance[v] = static_cast<float>(body.distance(p));
      const std::size_t column = window.first[0] + i + grid_.size[0] * (window.first[1] + j);
      if (columns_[column].depth < columns_[column].wall) continue;  // nothing reaches into the wall
      const float gas = share_inside(body.gas_above - p[1], voxel_);
      blend(hounsfield[column],
            static_cast<float>(body.hounsfield) + gas * (hu::gas - static_cast<float>(body.hounsfield)),
            share_inside(distance[v], voxel_));
    }
  }
}

}  // namespace calot
