// Where the instruments enter: the usual four ports, fitted to the patient.
#include <algorithm>
#include <array>
#include <cmath>

#include "calot/patient/landmarks_parts.h"

namespace calot::detail {
namespace {

constexpr double mm = 1e-3;
constexpr double clearance = 10 * mm;  // between a port and any organ

/// The levels that ports are measured from. Sources: docs/patient.md.
struct Levels {
  double umbilicus, xiphoid;  // z [m]
};

Levels levels_of(const OrganPlaces& organs, const Vec3& triangle) {
  // The fundus shows at the tip of the ninth rib, at the first lumbar vertebra; the umbilicus lies two to three
  // vertebrae lower, the tip of the xiphoid as far above.
  const double umbilicus = std::clamp(organs.fundus[2] - 80 * mm, triangle[2] - 165 * mm, triangle[2] - 100 * mm);
  return {umbilicus, umbilicus + 165 * mm};
}

double angle_at(const Vec3& at, const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp((a - at).normalized().dot((b - at).normalized()), -1.0, 1.0)) * 180 / M_PI;
}

/// A place on the wall near a nominal one, and what it costs to have moved there.
struct Candidate {
  Vec3 position;
  double cost;
};

/// Moves forward until no organ is near: where the wall is assumed, it may be assumed too low.
Vec3 clear_of_organs(Vec3 position, const LabelProbe& probe, double& moved) {
  moved = 0;
  while (moved < 80 * mm && probe.organ_within(position, clearance)) {
    position[1] += 2 * mm;
    moved += 2 * mm;
  }
  return position;
}

/// What an instrument through a port meets on its way to a target: distance, and organs that would have to be lifted.
double way_cost(const LabelProbe& probe, const Vec3& port, const Vec3& target) {
  const Vec3 way = target - port;
  const double length = way.norm(), off = std::max(0.0, std::abs(length - 150 * mm) - 30 * mm);
  const double blocked = length > 20 * mm ? probe.blocked(port, target - 15 * mm / length * way).length : 0;
  const double too_near = std::max(0.0, 105 * mm - length);
  return std::pow(off / (20 * mm), 2) + std::pow(too_near / (5 * mm), 2) + blocked / (20 * mm);
}

std::vector<Candidate> around(const AbdominalWall& wall, const LabelProbe& probe, double x, double z, double dx,
                              double down, double up, const Vec3& target) {
  std::vector<Candidate> candidates;
  for (double a = -dx; a <= dx + 1e-9; a += 10 * mm)
    for (double b = -down; b <= up + 1e-9; b += 10 * mm) {
      double moved = 0;
      const Vec3 position = clear_of_organs(wall.lifted(x + a, z + b), probe, moved);
      const double cost = (a * a + b * b) / std::pow(25 * mm, 2) + moved / (5 * mm) + way_cost(probe, position, target);
      candidates.push_back({position, cost});
    }
  return candidates;
}

double apart_cost(const Vec3& a, const Vec3& b) {
  return std::pow(std::max(0.0, 55 * mm - (a - b).norm()) / (10 * mm), 2);
}

/// The pair of working ports whose instruments meet at the triangle under about 60° [Manasnayakorn2008].
std::pair<Vec3, Vec3> choose_working(const std::vector<Candidate>& right, const std::vector<Candidate>& left,
                                     const Vec3& camera, const Vec3& target) {
  std::pair<Vec3, Vec3> best;
  double least = 1e300;
  for (const Candidate& r : right)
    for (const Candidate& l : left) {
      const double angle = angle_at(target, r.position, l.position);
      const double cost = r.cost + l.cost + std::pow((angle - 60) / 10, 2) + apart_cost(r.position, l.position) +
                          apart_cost(r.position, camera) + apart_cost(l.position, camera);
      if (cost >= least) continue;
      least = cost;
      best = {r.position, l.position};
    }
  return best;
}

void note_shortfalls(const std::vector<Port>& ports, const Vec3& target, const LabelProbe& probe,
                     std::vector<std::string>& notes) {
  const double angle = angle_at(target, ports[1].position, ports[2].position);
  if (angle < 30 || angle > 90)
    notes.push_back("the working instruments meet at Calot's triangle under " + std::to_string(std::lround(angle)) +
                    " degrees; about 60 would be comfortable");
  for (const Port& port : {ports[1], ports[2]}) {
    const double length = (target - port.position).norm();
    if (length < 100 * mm || length > 200 * mm)
      notes.push_back("the " + port.name + " port is " + in_mm(length) +
                      " from Calot's triangle; 100 to 200 mm are usual");
    const LabelProbe::Blocked blocked =
        probe.blocked(port.position, target - 15 * mm / length * (target - port.position));
    if (blocked.length > 2 * mm)
      notes.push_back("the straight way from the " + port.name + " port to Calot's triangle passes " +
                      in_mm(blocked.length) + " of the " + std::string(name_of(blocked.by)) +
                      ", which the assistant lifts in the operation");
  }
}

}  // namespace

std::vector<Port> find_ports(const AbdominalWall& rest, const OrganPlaces& organs, const CalotTriangle& triangle,
                             const LabelProbe& probe, std::vector<std::string>& notes) {
  AbdominalWall wall = rest;
  const Vec3 target = middle_of(triangle);
  const Levels levels = levels_of(organs, target);
  wall.set_umbilicus(levels.umbilicus);
  const double half = wall.half_width();
  double moved = 0;
  const Vec3 camera = clear_of_organs(wall.lifted(wall.midline(), levels.umbilicus), probe, moved);
  // Some 5 cm below the xiphoid, right of the falciform ligament; two fingers below the ribs in the midclavicular line.
  const auto right =
      around(wall, probe, wall.midline() + 15 * mm, levels.xiphoid - 50 * mm, 0, 50 * mm, 30 * mm, target);
  const auto left =
      around(wall, probe, wall.midline() + 0.6 * half, levels.umbilicus + 50 * mm, 20 * mm, 40 * mm, 30 * mm, target);
  const auto [epigastric, midclavicular] = choose_working(right, left, camera, target);
  auto lateral = around(wall, probe, wall.midline() + 0.88 * half, levels.umbilicus + 20 * mm, 10 * mm, 30 * mm,
                        30 * mm, organs.fundus);
  for (Candidate& c : lateral) c.cost += apart_cost(c.position, midclavicular);
  const auto axillary = std::min_element(lateral.begin(), lateral.end(),
                                         [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<Port> ports{
      {"camera", camera, 10 * mm, "laparoscope, at the umbilicus"},
      {"epigastric", epigastric, 10 * mm, "the surgeon's right hand: dissector, hook, clips; also takes the organ out"},
      {"midclavicular", midclavicular, 5 * mm, "the surgeon's left hand: holds the gallbladder's neck"},
      {"anterior axillary", axillary->position, 5 * mm, "the assistant: pushes the fundus up over the liver"}};
  note_shortfalls(ports, target, probe, notes);
  return ports;
}

}  // namespace calot::detail
