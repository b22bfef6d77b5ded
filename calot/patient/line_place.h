// Inside this room only: where a place is along a tube.
#pragma once
#include <map>

#include "calot/patient/centreline.h"
#include "calot/patient/structure.h"

namespace calot::detail {

/// The nearest place on a line to a point.
struct LineProjection {
  double arc_length = 0;  ///< from the first point [m]
  double distance = 0;    ///< of the point from the line [m]
};
LineProjection project(const Centreline& line, const Vec3& point);

/// The tubes' centrelines (those named as structures), each running towards the gallbladder: the end that is nearer to
/// the gallbladder's vertices is the last. Where the mesh has no gallbladder, as they are.
std::map<Structure, Centreline> lines_towards_gallbladder(const std::vector<Centreline>& lines, const TetMesh& mesh);

}  // namespace calot::detail
