// Centrelines in files: 3D Slicer's markups (.mrk.json) and a plain text table.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calot/patient/centreline.h"

namespace calot {

/// Writes one open curve a centreline (RAS, mm), the radii as a measurement "radius" on its control points.
/// Source: 3D Slicer, markups-schema-v1.0.3.
void write_markups(const std::filesystem::path& path, const std::vector<Centreline>& lines);

/// Reads centrelines by ending: .mrk.json (curves; coordinateSystem LPS or RAS, coordinateUnits mm or none; radii from
/// a measurement "radius" with controlPointValues, or from a constant "radius" or "diameter" measurement), or .txt /
/// .csv:
///   # comment
///   line cystic duct          starts a line; what follows are x y z radius in RAS mm, a point a row, spaces or commas
///   12.5 -3.0 41.0 1.4
/// Throws InputError naming file and line or field: anything that doesn't parse, a curve without radii, fewer than two
/// points, radii outside 0.2 … 15 mm, two points at the same place, neighbours farther apart than 60 mm, a turn sharper
/// than the radius allows isn't an error. Any bytes are safe.
std::vector<Centreline> read_centrelines(const std::filesystem::path& path);

}  // namespace calot
