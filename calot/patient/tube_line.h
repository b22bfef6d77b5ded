// Centrelines as they are drawn: checked, smooth, finely stepped, and in the direction that the rest relies on.
#pragma once
#include "calot/patient/label_edit.h"

namespace calot {

/// Checks given lines. Throws InputError: names that are no duct's or artery's or come twice, fewer than two points,
/// radii that aren't 0.2 … 15 mm, a line that leaves the CT's volume (names the face) or the body: no CT value above
/// −300 HU within 3 mm or twice the radius.
void check_lines(const std::vector<Centreline>& lines, const CtImage& ct);

/// The spline (Catmull-Rom) through a line's points, with radii in proportion, at steps of about `step` [m].
Centreline fine_line(const Centreline& line, double step);

/// Distance [m] of a place from the nearest voxel of any of `structures` (0 inside one), and that voxel.
struct Gap {
  double distance = 0;
  std::size_t voxel = 0;
  bool found = false;  ///< whether they have any voxel
};
Gap gap_to(const WorkLabels& labels, const StructureSet& structures, const Vec3& place);

/// Turns a line so that it runs from the bile duct or the artery's origin towards the gallbladder; bile ducts from
/// above downwards, the right hepatic artery from the left, where the aorta is, to the right.
void orient(Centreline& line, Structure tube, const WorkLabels& labels);

}  // namespace calot
