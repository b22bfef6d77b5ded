// Centrelines with radii, as 3D Slicer's markups (.mrk.json).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calot/mesh/tet_mesh.h"

namespace calot {

/// A curve along the middle of a tube.
struct Centreline {
  std::string name;
  std::vector<Vec3> points;   ///< p, in order [m], RAS
  std::vector<double> radii;  ///< p [m]
};

/// Arc length [m].
double length(const Centreline& line);

/// Writes one open curve a centreline (RAS, mm), the radii as a measurement "radius" on its control points.
/// Source: 3D Slicer, markups-schema-v1.0.3.
void write_markups(const std::filesystem::path& path, const std::vector<Centreline>& lines);

}  // namespace calot
