// Where tubes are clipped and cut, and the corners of Calot's triangle.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/patient/landmarks_parts.h"

namespace calot::detail {
namespace {

constexpr double mm = 1e-3;
constexpr double walk = 0.25 * mm;

bool is_gallbladder(Structure s) {
  return s == Structure::gallbladder || s == Structure::gallbladder_wall;
}

/// The part of a ring around a tube, `off` outside of its wall, that `wanted` holds for.
template <class Wanted>
double part_around(const LabelProbe& probe, const LinePlace& place, double off, const Wanted& wanted) {
  constexpr int ring = 24;
  const Vec3 a = place.direction.unitOrthogonal(), b = place.direction.cross(a);
  const double radius = place.radius + std::max(off, 1.5 * probe.voxel());
  int inside = 0;
  for (int k = 0; k < ring; ++k) {
    const double angle = 2 * M_PI * k / ring;
    inside += wanted(probe.at(place.point + radius * (std::cos(angle) * a + std::sin(angle) * b)));
  }
  return static_cast<double>(inside) / ring;
}

/// Whether a place of a tube lies in the gallbladder: its label says so, or most of what lies around the tube does (a
/// tube that was drawn into the gallbladder has its own label).
bool in_gallbladder(const LabelProbe& probe, const LinePlace& place) {
  return is_gallbladder(probe.at(place.point)) || part_around(probe, place, 1 * mm, is_gallbladder) >= 0.6;
}

/// Whether a duct runs along the liver there: a touch is not enough.
bool at_liver(const LabelProbe& probe, const LinePlace& place) {
  return part_around(probe, place, 2 * mm, [](Structure s) { return s == Structure::liver; }) >= 0.3;
}

double distance_to_gallbladder(const LabelProbe& probe, const Vec3& point) {
  constexpr double reach = 60 * mm;
  const auto found = probe.nearest(point, {Structure::gallbladder, Structure::gallbladder_wall}, reach);
  return found ? (*found - point).norm() : reach;
}

/// The tubes that a tube may spring from.
std::vector<const Centreline*> origins(const CompletedAnatomy& anatomy, Structure tube) {
  std::vector<const Centreline*> lines;
  const bool duct = tube == Structure::cystic_duct;
  for (const Structure s : duct ? std::vector{Structure::common_bile_duct, Structure::common_hepatic_duct}
                                : std::vector{Structure::right_hepatic_artery})
    if (const Centreline* line = line_of(anatomy, s)) lines.push_back(line);
  return lines;
}

std::string far_name(Structure tube) {
  return tube == Structure::cystic_duct ? "bile duct" : "hepatic artery";
}

}  // namespace

const Centreline* line_of(const CompletedAnatomy& anatomy, Structure s) {
  for (const Centreline& line : anatomy.lines)
    if (line.name == name_of(s) && line.points.size() >= 2) return &line;
  return nullptr;
}

double distance_from_tube(const Centreline& line, const Vec3& point) {
  double nearest = (point - line.points.front()).norm() - line.radii.front();
  for (std::size_t p = 1; p < line.points.size(); ++p) {
    const Vec3 along = line.points[p] - line.points[p - 1], from = point - line.points[p - 1];
    const double t = std::clamp(along.dot(from) / std::max(along.squaredNorm(), 1e-30), 0.0, 1.0);
    nearest = std::min(nearest, (from - t * along).norm() - ((1 - t) * line.radii[p - 1] + t * line.radii[p]));
  }
  return nearest;
}

FreeTube free_tube(const CompletedAnatomy& anatomy, const LabelProbe& probe, Structure tube) {
  FreeTube result{tube, *line_of(anatomy, tube), 0, 0};
  Centreline& line = result.line;
  if (distance_to_gallbladder(probe, line.points.front()) < distance_to_gallbladder(probe, line.points.back())) {
    std::reverse(line.points.begin(), line.points.end());
    std::reverse(line.radii.begin(), line.radii.end());
  }
  const double total = length(line);
  const std::vector<const Centreline*> from = origins(anatomy, tube);
  const auto at_origin = [&](double s) {
    const Vec3 p = place_at(line, s).point;
    return std::any_of(from.begin(), from.end(), [&](const auto* other) { return distance_from_tube(*other, p) < 0; });
  };
  while (result.begin < total && at_origin(result.begin)) result.begin += walk;
  result.end = total;
  while (result.end > result.begin && in_gallbladder(probe, place_at(line, result.end))) result.end -= walk;
  if (result.end - result.begin < 2 * mm)
    throw FailedError(std::string(name_of(tube)),
                      "has no free part between the " + far_name(tube) + " and the gallbladder",
                      "draw its centreline from the one to the other");
  return result;
}

CalotTriangle find_triangle(const CompletedAnatomy& anatomy, const LabelProbe& probe, const FreeTube& duct,
                            std::vector<std::string>& notes) {
  CalotTriangle triangle;
  triangle.duct_corner = place_at(duct.line, duct.begin).point;
  triangle.neck_corner = place_at(duct.line, duct.end).point;
  const Centreline* hepatic = line_of(anatomy, Structure::common_hepatic_duct);
  if (hepatic == nullptr) hepatic = line_of(anatomy, Structure::common_bile_duct);
  Centreline up = *hepatic;
  if ((up.points.back() - triangle.duct_corner).norm() < (up.points.front() - triangle.duct_corner).norm() ||
      (line_of(anatomy, Structure::common_hepatic_duct) == nullptr && up.points.back()[2] < up.points.front()[2])) {
    std::reverse(up.points.begin(), up.points.end());
    std::reverse(up.radii.begin(), up.radii.end());
  }
  constexpr double reach = 60 * mm;
  const double total = length(up);
  double start = 0, nearest = 1e300;  // the junction, on a line that goes on below it
  for (double s = 0; s <= total; s += 2 * walk) {
    const double distance = (place_at(up, s).point - triangle.duct_corner).norm();
    if (distance < nearest) nearest = distance, start = s;
  }
  for (double s = start + 5 * mm; s <= total; s += 2 * walk) {
    const LinePlace place = place_at(up, s);
    if (at_liver(probe, place)) {
      triangle.liver_corner = place.point;
      return triangle;
    }
  }
  const auto liver = probe.nearest(up.points.back(), {Structure::liver}, reach);
  triangle.liver_corner = liver.value_or(up.points.back());
  notes.push_back("the hepatic duct " +
                  (liver ? "ends " + in_mm((*liver - up.points.back()).norm()) + " before the liver"
                         : "comes nowhere near the liver") +
                  "; the upper corner of Calot's triangle is " +
                  (liver ? "the liver's nearest point to its upper end" : "its upper end"));
  return triangle;
}

/// From the far wall to the gallbladder's: margin, clip, clip, cut, clip, margin. The layout for a short tube lets
/// clips of 2 mm just fit on 8 mm; that for a long one leaves room, and keeps away from the far duct; between them in
/// proportion.
void add_tube_sites(const FreeTube& tube, Landmarks& landmarks) {
  constexpr std::array<double, 5> tight{1.2 * mm, 2.2 * mm, 1.7 * mm, 1.7 * mm, 1.2 * mm};
  constexpr std::array<double, 5> roomy{6 * mm, 4.5 * mm, 4 * mm, 4 * mm, 3.5 * mm};
  const double free = tube.end - tube.begin, least = 8 * mm, ample = 22 * mm;
  const double t = std::clamp((free - least) / (ample - least), 0.0, 1.0);
  std::array<double, 5> gaps{};
  double sum = 0;
  for (std::size_t g = 0; g < gaps.size(); ++g) sum += gaps[g] = (1 - t) * tight[g] + t * roomy[g];
  // A long tube: the rest goes to the far side, so that the clips sit near the gallbladder.
  if (sum < free) gaps[0] += free - sum;
  if (sum > free)
    for (double& gap : gaps) gap *= free / sum;
  const std::string name(name_of(tube.tube));
  if (free < least)
    landmarks.notes.push_back("the " + name + " is free over " + in_mm(free) +
                              " only: three clips of 2 mm don't fit side by side");
  else if (free < ample)
    landmarks.notes.push_back("the " + name + " is free over " + in_mm(free) + ": its clips stand closer than usual");
  const auto site = [&](const std::string& what, double from_wall) {
    const LinePlace place = place_at(tube.line, tube.begin + from_wall);
    return TubeSite{name + ", " + what, tube.tube, tube.begin + from_wall, place.point, place.direction, place.radius};
  };
  const std::string towards = " (towards the " + far_name(tube.tube) + ")";
  landmarks.clips.push_back(site("clip 1" + towards, gaps[0]));
  landmarks.clips.push_back(site("clip 2" + towards, gaps[0] + gaps[1]));
  landmarks.cuts.push_back(site("cut", gaps[0] + gaps[1] + gaps[2]));
  landmarks.clips.push_back(site("clip 3 (towards the gallbladder)", gaps[0] + gaps[1] + gaps[2] + gaps[3]));
}

}  // namespace calot::detail
