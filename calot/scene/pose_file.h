// Recorded poses of an instrument, as a table.
#pragma once
#include <filesystem>

#include "calot/scene/instrument_script.h"

namespace calot {

/// Reads a CSV file: a header line with the names of the columns in any order, then a line a pose. time [s], x, y, z
/// (the instrument's frame, in `metres` per unit), qw, qx, qy, qz (rotation, made a unit quaternion) are needed;
/// opening [°], grip [N], energy and fire (0 or 1) may be there. Throws InputError naming file and line.
InstrumentScript read_poses(const std::filesystem::path& path, double metres);

}  // namespace calot
