// The arteries of the field, and the aberrant duct: each finds its way between those that are there.
#include <algorithm>
#include <cmath>
#include <optional>

#include "calot/base/error.h"
#include "calot/patient/phantom_field.h"
#include "calot/patient/phantom_paths.h"
#include "calot/patient/phantom_tree.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;
constexpr double blood_hounsfield = 41, bile_hounsfield = 3;
constexpr double inside_wall = 1.2 * mm;  ///< how deep an artery enters the gallbladder's outside
constexpr double least_gap = 0.6 * mm;    ///< between vessels that don't join

/// The best of what was tried.
struct Choice {
  Curve path;
  double score = -1, gap = -1;
  void offer(const Curve& candidate, double candidate_gap, double detour) {
    const double candidate_score = std::min(candidate_gap, 2 * mm) - 0.1 * detour;
    if (!path.empty() && candidate_score <= score) return;
    path = candidate, score = candidate_score, gap = candidate_gap;
  }
};

FieldTube as_tube(Structure structure, const Curve& path, double diameter, double hounsfield) {
  const Curve line = resampled(path, 0.2 * mm);
  return {
      structure, {std::string(name_of(structure)), line, std::vector<double>(line.size(), diameter / 2)}, hounsfield};
}

/// None where there was no room.
std::optional<FieldTube> chosen(const Choice& choice, Structure structure, double diameter, double hounsfield) {
  if (choice.gap < least_gap) return {};
  return as_tube(structure, choice.path, diameter, hounsfield);
}

/// A point of the hepatic duct so far above the hub.
Vec3 above_hub(const OperatingField& field, double height) {
  const Curve& bile = field.bile_duct.points;
  std::size_t p = 0;
  while (p + 1 < bile.size() && (bile[p] - field.hub).norm() > height) ++p;
  return bile[p];
}

/// Moves a point along a direction until it lies so deep in the liver.
Vec3 into_liver(const OperatingField& field, Vec3 p, const Vec3& direction, double depth) {
  for (int step = 0; step < 160 && field.liver.field.at(p) > -depth; ++step) p += 0.5 * mm * direction;
  return p;
}

/// Where an artery from `p` enters the gallbladder at the height of one of its balls.
Vec3 entry(const Ball& ball, const Vec3& p) {
  return ball.centre + (ball.radius - inside_wall) * (p - ball.centre).normalized();
}

/// Directions across the line of sight between two points.
std::vector<Vec3> sides_of(const Vec3& from, const Vec3& to) {
  const Vec3 chord = (to - from).normalized(), a = chord.unitOrthogonal(), b = chord.cross(a);
  std::vector<Vec3> sides;
  for (int i = 0; i < 8; ++i) sides.emplace_back(std::cos(M_PI * i / 4) * a + std::sin(M_PI * i / 4) * b);
  return sides;
}

/// The part of an artery's middle line between the wall of its parent and the gallbladder's outside.
double free_length(const Curve& path, const FieldTube& parent, const BallChain& gallbladder) {
  std::size_t first = 0, last = path.size() - 1;
  while (first + 1 < last && distance_to_tube(parent.line.points, parent.radius(), path[first]) < 0) ++first;
  while (last > first + 1 && distance_to(gallbladder, path[last]) < 0) --last;
  double sum = 0;
  for (std::size_t p = first; p < last; ++p) sum += (path[p + 1] - path[p]).norm();
  return sum;
}

/// From the left, behind the common hepatic duct, to the right and up into the liver beside the hilum. Diameter and
/// course are our choice.
FieldTube right_hepatic_artery(Random& random, const OperatingField& field) {
  const double diameter = random.uniform(3.0, 4.0) * mm, gap = random.uniform(0.9, 1.5) * mm;
  const Vec3 duct = above_hub(field, random.uniform(15, 19) * mm);
  const Vec3 behind = duct - Vec3(0, field.bile_duct.radii[0] + diameter / 2 + gap, 0);
  const auto wander = [&] { return random.uniform(-1, 1) * mm; };
  const Vec3 right = behind + Vec3(8 * mm, wander(), 4.5 * mm + wander());
  const Vec3 upward = Vec3(0.55, 0.12, 0.83).normalized();
  const Vec3 end = into_liver(field, right + 5 * mm * upward, upward, 4 * mm);
  const Curve line = spline({field.hub + Vec3(-27 * mm, -3 * mm + wander(), -5 * mm + wander()),
                             field.hub + Vec3(-12 * mm, -5 * mm + wander(), 8 * mm + wander()), behind, right,
                             right + 5 * mm * upward, end});
  return as_tube(Structure::right_hepatic_artery, line, diameter, blood_hounsfield);
}

/// From the liver beside the hilum across Calot's triangle into the hepatic duct's right side.
std::optional<FieldTube> aberrant_right_duct(Random& random, const OperatingField& field) {
  const double diameter = random.uniform(2.2, 3.0) * mm, radius = diameter / 2, bile = field.bile_duct.radii[0];
  const FieldTube& cystic = field.tube(Structure::cystic_duct);
  const FieldTube& artery = field.tube(Structure::right_hepatic_artery);
  Obstacles others{{{&field.bile_duct.points, bile, 0, bile + radius + 3 * mm},
                    {&cystic.line.points, cystic.radius()},
                    {&artery.line.points, artery.radius()}}};
  others.liver = &field.liver.field;
  others.liver_ignored_near_start = 9 * mm;
  const Vec3 hilum = field.bile_duct.points[12], neck = field.outside.front().centre;
  Choice choice;
  for (const double share : {0.35, 0.5, 0.65})
    for (const double across : {-2.0, 2.0, 6.0}) {
      const Vec3 under = hilum + share * (neck - hilum) + across * mm * field.liver.form.across;
      const Vec3 start = into_liver(field, under, -field.liver.form.down, 4 * mm);
      for (const double height : {5.0, 7.0, 9.0, 11.0}) {
        const Vec3 end = above_hub(field, height * mm);
        for (const Vec3& side : sides_of(start, end))
          for (const double bow : {1.0, 2.5, 4.0}) {
            const Curve path = bowed(start, end, side, bow * mm);
            choice.offer(path, clearance(path, radius, others), bow * mm);
          }
      }
    }
  return chosen(choice, Structure::aberrant_right_duct, diameter, bile_hounsfield);
}

/// Bows the chord until its free part has this length; none where the chord is too long, or a bow of 10 mm too short.
std::optional<double> bow_for_length(const Vec3& start, const Vec3& end, const Vec3& side, double wanted,
                                     const FieldTube& parent, const BallChain& gallbladder) {
  const auto length_at = [&](double bow) { return free_length(bowed(start, end, side, bow), parent, gallbladder); };
  double low = 0.3 * mm, high = 10 * mm;
  if (length_at(low) > wanted || length_at(high) < wanted) return {};
  for (int step = 0; step < 10; ++step) {
    const double middle = (low + high) / 2;
    (length_at(middle) < wanted ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Obstacles of an artery from the right hepatic artery to the gallbladder.
Obstacles around_arteries(const OperatingField& field) {
  Obstacles others{{{&field.bile_duct.points, field.bile_duct.radii[0]}}};
  for (const FieldTube& tube : field.tubes)
    others.tubes.push_back(
        {&tube.line.points, tube.radius(), tube.structure == Structure::right_hepatic_artery ? 5 * mm : 0.0});
  others.liver = &field.liver.field;
  others.gallbladder = &field.outside;
  others.gallbladder_ignored_near_end = 8 * mm;
  return others;
}

/// Where a cystic artery may begin and end.
struct Ends {
  Vec3 start, end;
};

/// From the right hepatic artery, right of the hepatic duct, to the side of the gallbladder's neck that faces it.
std::vector<Ends> ends_of_artery(const OperatingField& field) {
  const FieldTube& parent = field.tube(Structure::right_hepatic_artery);
  const double beside = field.bile_duct.radii[0] + parent.radius() + 1.5 * mm;
  std::vector<Ends> ends;
  for (std::size_t p = 0; p < parent.line.points.size(); p += 8) {
    const Vec3& start = parent.line.points[p];
    if (start[0] < field.hub[0] || distance_to(field.bile_duct.points, start) < beside) continue;
    if (field.liver.field.at(start) < parent.radius()) continue;
    for (const std::size_t share : {0u, 6u, 12u, 18u, 24u, 30u})
      ends.push_back({start, entry(field.outside[field.outside.size() * share / 100], start)});
  }
  return ends;
}

/// Through Calot's triangle to the gallbladder's neck, as long as drawn from the published range, or from that part of
/// it that the two ends leave.
std::optional<FieldTube> cystic_artery(Random& random, OperatingField& field) {
  PhantomFacts& facts = field.facts;
  const FieldTube& parent = field.tube(Structure::right_hepatic_artery);
  const std::vector<Ends> ends = ends_of_artery(field);
  double shortest = 17.1 * mm;
  if (!ends.empty()) {
    double direct = 1;
    for (const Ends& e : ends)
      direct = std::min(direct, free_length(bowed(e.start, e.end, {0, 0, 1}, 1 * mm), parent, field.outside));
    shortest = std::clamp(1.05 * direct, shortest, 26 * mm);
  }
  facts.cystic_artery_length = random.uniform(shortest, 26.8 * mm);
  facts.cystic_artery_diameter = random.uniform(1.2, 1.6) * mm;
  const double radius = facts.cystic_artery_diameter / 2;
  const Obstacles others = around_arteries(field);
  Choice choice;
  for (const auto& [start, end] : ends)
    for (const Vec3& side : sides_of(start, end))
      if (const auto bow = bow_for_length(start, end, side, facts.cystic_artery_length, parent, field.outside)) {
        const Curve path = bowed(start, end, side, *bow);
        choice.offer(path, clearance(path, radius, others), *bow);
      }
  return chosen(choice, Structure::cystic_artery, facts.cystic_artery_diameter, blood_hounsfield);
}

/// From the right hepatic artery, before or while that passes the hepatic duct, behind the cystic duct to the
/// gallbladder's back. As thick as cystic arteries are; its course is our choice.
std::optional<FieldTube> second_cystic_artery(Random& random, const OperatingField& field) {
  const double diameter = random.uniform(1.2, 1.6) * mm, radius = diameter / 2;
  const FieldTube& parent = field.tube(Structure::right_hepatic_artery);
  const FieldTube& duct = field.tube(Structure::cystic_duct);
  const Obstacles others = around_arteries(field);
  Choice choice;
  for (std::size_t p = 0; p < parent.line.points.size(); p += 12) {
    const Vec3& start = parent.line.points[p];
    if ((start - above_hub(field, 17 * mm)).norm() > 12 * mm || field.liver.field.at(start) < parent.radius()) continue;
    for (const double share : {0.15, 0.3, 0.45, 0.6})
      for (const double gap : {1.3, 2.2, 3.2})
        for (const std::size_t along : {5u, 10u, 15u, 20u, 25u}) {
          const auto at = static_cast<std::size_t>(share * static_cast<double>(duct.line.points.size()));
          const Vec3 way = duct.line.points[at] - Vec3(0, duct.radius() + radius + gap * mm, 0);
          const Ball& ball = field.outside[field.outside.size() * along / 100];
          const Curve path = resampled(spline({start, way, entry(ball, way)}), 0.8 * mm);
          choice.offer(path, clearance(path, radius, others), 0.02 * length({"", path, {}}));
        }
  }
  return chosen(choice, Structure::second_cystic_artery, diameter, blood_hounsfield);
}

}  // namespace

void draw_field_vessels(PhantomVariant variant, Random& random, OperatingField& field) {
  const std::vector<FieldTube> ducts = field.tubes;
  for (int attempt = 0; attempt < 20; ++attempt) {
    // In the order of painting: where two meet, the later one wins, so that a branch ends at its parent's wall.
    field.tubes = ducts;
    const auto put_first = [&](const std::optional<FieldTube>& tube) {
      if (tube) field.tubes.insert(field.tubes.begin(), *tube);
      return tube.has_value();
    };
    put_first(right_hepatic_artery(random, field));
    if (variant == PhantomVariant::aberrant_right_duct && !put_first(aberrant_right_duct(random, field))) continue;
    if (!put_first(cystic_artery(random, field))) continue;
    if (variant == PhantomVariant::second_cystic_artery && !put_first(second_cystic_artery(random, field))) continue;
    return;
  }
  throw FailedError("phantom", "found no room for the vessels in Calot's triangle", "try another seed");
}

}  // namespace calot
