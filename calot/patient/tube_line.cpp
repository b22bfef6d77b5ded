#include "calot/patient/tube_line.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "calot/base/error.h"
#include "calot/patient/border.h"
#include "calot/patient/sweep.h"

namespace calot {
namespace {

constexpr double air_below = -300;  // HU

std::string where_of(const Centreline& line) {
  return "centreline \"" + line.name + "\"";
}

std::string tube_names() {
  std::string names;
  for (const Structure s : all_structures())
    if (is_tube(s)) names += (names.empty() ? "" : ", ") + std::string(name_of(s));
  return names;
}

void check_form(const Centreline& line) {
  const std::optional<Structure> structure = structure_named(line.name);
  if (!structure || !is_tube(*structure))
    throw InputError(where_of(line), "is no duct or artery that Calot knows", "name it one of: " + tube_names());
  if (line.points.size() < 2 || line.radii.size() != line.points.size())
    throw InputError(where_of(line), "needs two or more points, each with a radius");
  for (std::size_t p = 0; p < line.points.size(); ++p) {
    if (!line.points[p].allFinite()) throw InputError(where_of(line), text_of("point %zu isn't finite", p));
    if (!(line.radii[p] >= 0.2e-3 && line.radii[p] <= 15e-3))
      throw InputError(where_of(line), text_of("the radius at point %zu isn't in 0.2 … 15 mm", p), "give it in mm");
  }
}

void check_in_volume(const Centreline& line, const Vec3& place, const VoxelGrid& grid) {
  const Vec3 at = grid.to_world.inverse() * place;
  for (int d = 0; d < 3; ++d) {
    const bool below = at[d]<-0.5, above = at[d]> static_cast<double>(grid.size[static_cast<std::size_t>(d)]) - 0.5;
    if (!below && !above) continue;
    throw InputError(where_of(line),
                     "leaves the volume through its " + side_name(grid, d, above) + " end, at " + place_text(place),
                     "end it inside, or give a larger CT; its coordinates are RAS");
  }
}

/// Whether there is anything but air around a place.
bool in_body(const CtImage& ct, const Vec3& place, double reach) {
  const Vec3 at = ct.grid.to_world.inverse() * place, spacing = ct.grid.spacing();
  std::array<std::ptrdiff_t, 3> low{}, high{};
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    const double last = static_cast<double>(ct.grid.size[d] - 1), middle = std::clamp(std::round(at[axis]), 0.0, last);
    low[d] = static_cast<std::ptrdiff_t>(std::max(0.0, std::min(middle, std::ceil(at[axis] - reach / spacing[axis]))));
    high[d] =
        static_cast<std::ptrdiff_t>(std::min(last, std::max(middle, std::floor(at[axis] + reach / spacing[axis]))));
  }
  for (std::ptrdiff_t k = low[2]; k <= high[2]; ++k)
    for (std::ptrdiff_t j = low[1]; j <= high[1]; ++j)
      for (std::ptrdiff_t i = low[0]; i <= high[0]; ++i)
        if (ct.hounsfield[ct.grid.index(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                                        static_cast<std::size_t>(k))] > air_below)
          return true;
  return false;
}

double gap_between(const WorkLabels& labels, const StructureSet& structures, const Vec3& place) {
  const Gap gap = gap_to(labels, structures, place);
  return gap.found ? gap.distance : 0;
}

}  // namespace

void check_lines(const std::vector<Centreline>& lines, const CtImage& ct) {
  std::set<std::string> names;
  for (const Centreline& line : lines) {
    check_form(line);
    if (!names.insert(line.name).second) throw InputError(where_of(line), "comes twice", "leave one of them");
    for (const Vec3& p : line.points) check_in_volume(line, p, ct.grid);
    const Centreline fine = fine_line(line, 1e-3);
    for (std::size_t p = 0; p < fine.points.size(); ++p) {
      check_in_volume(line, fine.points[p], ct.grid);
      if (!in_body(ct, fine.points[p], std::max(3e-3, 2 * fine.radii[p])))
        throw InputError(where_of(line), "runs through air at " + place_text(fine.points[p]) + ", outside of the body",
                         "check that it belongs to this CT; its coordinates are RAS");
    }
  }
}

Centreline fine_line(const Centreline& line, double step) {
  const Curve curve = spline(line.points);
  const double pieces = static_cast<double>(curve.size() - 1) / static_cast<double>(line.points.size() - 1);
  std::vector<double> place(curve.size(), 0.0), radius(curve.size());
  for (std::size_t c = 0; c < curve.size(); ++c) {
    if (c > 0) place[c] = place[c - 1] + (curve[c] - curve[c - 1]).norm();
    const double at = static_cast<double>(c) / pieces;
    const auto low = std::min(static_cast<std::size_t>(at), line.radii.size() - 2);
    const double t = at - static_cast<double>(low);
    radius[c] = (1 - t) * line.radii[low] + t * line.radii[low + 1];
  }
  const auto count = static_cast<std::size_t>(std::max(1.0, std::round(place.back() / step)));
  Centreline fine{line.name, {}, {}};
  std::size_t c = 1;
  for (std::size_t p = 0; p <= count; ++p) {
    const double wanted = place.back() * static_cast<double>(p) / static_cast<double>(count);
    while (c + 1 < curve.size() && place[c] < wanted) ++c;
    const double piece = place[c] - place[c - 1], t = piece > 0 ? std::min(1.0, (wanted - place[c - 1]) / piece) : 0.0;
    fine.points.push_back(curve[c - 1] + t * (curve[c] - curve[c - 1]));
    fine.radii.push_back((1 - t) * radius[c - 1] + t * radius[c]);
  }
  return fine;
}

Gap gap_to(const WorkLabels& labels, const StructureSet& structures, const Vec3& place) {
  const Vec3 at = labels.grid.to_world.inverse() * place, spacing = labels.grid.spacing();
  std::array<bool, 256> wanted{};
  for (const Structure s : all_structures()) wanted[label_of(s)] = structures.contains(s);
  const auto& size = labels.grid.size;
  Gap best;
  double least = std::numeric_limits<double>::infinity();
  std::size_t v = 0;
  for (std::size_t k = 0; k < size[2]; ++k) {
    const double z = std::max(0.0, std::abs(static_cast<double>(k) - at[2]) - 0.5) * spacing[2];
    if (z * z >= least) {
      v += size[0] * size[1];
      continue;
    }
    for (std::size_t j = 0; j < size[1]; ++j) {
      const double y = std::max(0.0, std::abs(static_cast<double>(j) - at[1]) - 0.5) * spacing[1];
      for (std::size_t i = 0; i < size[0]; ++i, ++v) {
        if (!wanted[labels.voxels[v]]) continue;
        const double x = std::max(0.0, std::abs(static_cast<double>(i) - at[0]) - 0.5) * spacing[0];
        const double squared = x * x + y * y + z * z;
        if (squared >= least) continue;
        least = squared;
        best = {std::sqrt(squared), v, true};
      }
    }
  }
  return best;
}

void orient(Centreline& line, Structure tube, const WorkLabels& labels) {
  const Vec3 first = line.points.front(), last = line.points.back();
  bool turn = false;
  switch (tube) {
    case Structure::common_bile_duct:
    case Structure::common_hepatic_duct:
    case Structure::aberrant_right_duct:
      turn = first[2] < last[2];
      break;
    case Structure::right_hepatic_artery:
      turn = first[0] > last[0];
      break;
    default: {
      const StructureSet sac{Structure::gallbladder, Structure::gallbladder_wall};
      const StructureSet origin = tube == Structure::cystic_duct
                                      ? StructureSet{Structure::common_bile_duct, Structure::common_hepatic_duct,
                                                     Structure::aberrant_right_duct}
                                      : StructureSet{Structure::right_hepatic_artery};
      const double straight = gap_between(labels, sac, last) + gap_between(labels, origin, first);
      turn = gap_between(labels, sac, first) + gap_between(labels, origin, last) < straight;
    }
  }
  if (!turn) return;
  std::reverse(line.points.begin(), line.points.end());
  std::reverse(line.radii.begin(), line.radii.end());
}

}  // namespace calot
