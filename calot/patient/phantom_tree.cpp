#include "calot/patient/phantom_tree.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

/// The pear: radius along its axis, narrow at the neck, widest at three quarters, a little less at the fundus.
double pear_radius(double t, double neck, double widest) {
  const double rise = std::min(t / 0.75, 1.0);
  const double fall = std::max(0.0, (t - 0.75) / 0.25);
  return neck + (widest - neck) * rise * rise * (3 - 2 * rise) - 0.1 * widest * fall * fall;
}

struct Pear {
  Vec3 neck, direction, bend;  ///< neck's place, unit axis towards the fundus, sideways bow [m]
  double length, neck_radius;  ///< [m]
};

BallChain pear(const Pear& shape, double widest) {
  const double axis = shape.length - shape.neck_radius - pear_radius(1, shape.neck_radius, widest);
  const int count = static_cast<int>(axis / (0.4 * mm));
  BallChain balls;
  for (int i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) / count;
    const Vec3 centre = shape.neck + t * axis * shape.direction + 4 * t * (1 - t) * shape.bend;
    balls.push_back({centre, pear_radius(t, shape.neck_radius, widest)});
  }
  return balls;
}

}  // namespace

Vec3 vary(Random& random, const Vec3& v, double spread) {
  Vec3 moved = v.normalized();
  for (int d = 0; d < 3; ++d) moved[d] += random.uniform(-spread, spread);
  return moved.normalized();
}

double limited_normal(Random& random, double mean, double deviation, double low, double high) {
  return std::clamp(mean + deviation * random.normal(), low, high);
}

Centreline draw_bile_duct(Random& random, PhantomFacts& facts) {
  facts.bile_duct_length = random.uniform(70, 80) * mm;
  facts.bile_duct_diameter = random.uniform(4.5, 6.0) * mm;
  facts.hepatic_duct_length = random.uniform(25, 32) * mm;
  const auto wander = [&] { return random.uniform(-1.5, 1.5); };
  const Curve above = scaled_to_length(spline({{0, 0, 0}, {2 + wander(), 1, 15}, {6 + wander(), 4 + wander(), 30}}),
                                       facts.hepatic_duct_length);
  const Curve below = scaled_to_length(spline({{0, 0, 0},
                                               {-3 + wander(), -4 + wander(), -25},
                                               {-2 + wander(), -10 + wander(), -50},
                                               {7 + wander(), -13 + wander(), -72}}),
                                       facts.bile_duct_length);
  Curve whole(above.rbegin(), above.rend());
  whole.insert(whole.end(), below.begin() + 1, below.end());
  const Curve line = resampled(whole, 0.25 * mm);
  const double radius = facts.bile_duct_diameter / 2;
  return {"common bile duct", line, std::vector<double>(line.size(), radius)};
}

BallChain draw_gallbladder(Random& random, const Vec3& neck, double neck_radius, PhantomFacts& facts) {
  facts.gallbladder_volume = random.uniform(31, 49) * 1e-6;
  facts.gallbladder_length = random.uniform(72, 95) * mm;
  const Vec3 axis = vary(random, {0.40, 0.62, -0.68}, 0.08);
  const Vec3 bow = axis.cross(Vec3(0, -0.8, -0.6)).cross(axis).normalized() * random.uniform(2, 5) * mm;
  for (int attempt = 0; attempt < 40; ++attempt) {
    const Pear shape{neck, axis, bow, facts.gallbladder_length, neck_radius};
    double low = 10 * mm, high = 30 * mm;
    for (int step = 0; step < 24; ++step) {
      const double middle = (low + high) / 2;
      (volume_of_revolution(pear(shape, middle)) < facts.gallbladder_volume ? low : high) = middle;
    }
    facts.gallbladder_width = low + high;
    if (facts.gallbladder_width >= 30.5 * mm && facts.gallbladder_width <= 49 * mm)
      return pear(shape, (low + high) / 2);
    facts.gallbladder_length *= facts.gallbladder_width < 40 * mm ? 0.97 : 1.03;
  }
  throw FailedError("phantom", "found no gallbladder within the published ranges", "try another seed");
}

double visible_length(const Curve& line, double neck_radius, const Centreline& bile) {
  double sum = 0;
  for (std::size_t p = 1; p < line.size(); ++p) {
    const Vec3 middle = (line[p] + line[p - 1]) / 2;
    if ((middle - line.front()).norm() < neck_radius || distance_to(bile.points, middle) < bile.radii[0]) continue;
    sum += (line[p] - line[p - 1]).norm();
  }
  return sum;
}

void draw_cystic_duct_sizes(Random& random, PhantomFacts& facts) {
  facts.cystic_duct_length = limited_normal(random, 27.4, 4, 20, 38) * mm;
  facts.cystic_duct_diameter = limited_normal(random, 2.84, 0.25, 2.4, 3.4) * mm;
}

Centreline draw_cystic_duct(Random& random, double neck_radius, const Centreline& bile, const PhantomFacts& facts) {
  const Vec3 out = vary(random, {0.72, 0.42, 0.50}, 0.08);
  const Vec3 side = out.cross(vary(random, {0.2, -0.6, 0.7}, 0.2)).normalized(), up = out.cross(side);
  const double waves = random.uniform(1.3, 1.8), height = random.uniform(0.045, 0.07), turn = random.uniform(0, 6.28);
  const auto shape = [&](double reach) {
    Curve line;
    for (int i = 0; i <= 200; ++i) {
      const double t = i / 200.0, swing = height * std::sin(M_PI * t), angle = 2 * M_PI * waves * t + turn;
      const Vec3 base = (1 - t) * out + Vec3(0.10, 0.06, 0.16) * 4 * t * (1 - t);
      line.push_back(reach * (base + swing * (std::cos(angle) * side + std::sin(angle) * up)));
    }
    return line;
  };
  double low = 10 * mm, high = 60 * mm;
  for (int step = 0; step < 30; ++step) {
    const double middle = (low + high) / 2;
    (visible_length(shape(middle), neck_radius, bile) < facts.cystic_duct_length ? low : high) = middle;
  }
  const Curve line = resampled(shape((low + high) / 2), 0.2 * mm);
  return {"cystic duct", line, std::vector<double>(line.size(), facts.cystic_duct_diameter / 2)};
}

}  // namespace calot
