#include "calot/patient/landmarks.h"

#include <algorithm>
#include <array>

#include "calot/base/error.h"
#include "calot/patient/landmarks_parts.h"

namespace calot {
namespace {

using detail::FreeTube;
using detail::LabelProbe;
using detail::OrganPlaces;

constexpr double mm = 1e-3;

void check(const CompletedAnatomy& anatomy) {
  if (detail::line_of(anatomy, Structure::cystic_duct) == nullptr)
    throw FailedError("landmarks", "the anatomy has no centreline of the cystic duct", "draw one");
  if (detail::line_of(anatomy, Structure::common_bile_duct) == nullptr &&
      detail::line_of(anatomy, Structure::common_hepatic_duct) == nullptr)
    throw FailedError("landmarks", "the anatomy has no centreline of the bile duct", "draw one");
}

OrganPlaces find_places(const LabelMap& labels, const CalotTriangle& triangle) {
  constexpr double near = 80 * mm;
  const Vec3 middle = detail::middle_of(triangle);
  OrganPlaces places;
  places.fundus = triangle.neck_corner;
  Vec3 sum = Vec3::Zero(), everywhere = Vec3::Zero();
  std::size_t count = 0, all = 0;
  double farthest = 0;
  const auto& n = labels.grid.size;
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    const auto s = static_cast<Structure>(labels.voxels[v]);
    if (s != Structure::liver && s != Structure::gallbladder && s != Structure::gallbladder_wall) continue;
    const Vec3 p = labels.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                               static_cast<double>(v / (n[0] * n[1])));
    if (s == Structure::liver) {
      everywhere += p, ++all;
      if ((p - middle).norm() < near) sum += p, ++count;
    } else if ((p - triangle.neck_corner).norm() > farthest) {
      farthest = (p - triangle.neck_corner).norm();
      places.fundus = p;
    }
  }
  if (all == 0) throw FailedError("landmarks", "the anatomy has no liver", "label it");
  if (farthest == 0) throw FailedError("landmarks", "the anatomy has no gallbladder", "label it");
  places.liver_middle =
      count > 0 ? Vec3(sum / static_cast<double>(count)) : Vec3(everywhere / static_cast<double>(all));
  return places;
}

}  // namespace

Landmarks find_landmarks(const CompletedAnatomy& anatomy) {
  check(anatomy);
  Landmarks landmarks;
  const LabelProbe probe(anatomy.labels);
  const FreeTube duct = detail::free_tube(anatomy, probe, Structure::cystic_duct);
  landmarks.triangle = detail::find_triangle(anatomy, probe, duct, landmarks.notes);
  detail::add_tube_sites(duct, landmarks);
  for (const Structure artery : {Structure::cystic_artery, Structure::second_cystic_artery})
    if (detail::line_of(anatomy, artery) != nullptr)
      detail::add_tube_sites(detail::free_tube(anatomy, probe, artery), landmarks);
  const OrganPlaces places = find_places(anatomy.labels, landmarks.triangle);
  const AbdominalWall wall(anatomy, landmarks.triangle.duct_corner, landmarks.notes);
  landmarks.ports = detail::find_ports(wall, places, landmarks.triangle, probe, landmarks.notes);
  landmarks.camera = detail::find_camera(landmarks.ports.front(), places, landmarks.triangle, probe, landmarks.notes);
  return landmarks;
}

}  // namespace calot
