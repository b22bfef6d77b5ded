// Scene files. Their keys: docs/formats.md.
#pragma once
#include <filesystem>
#include <iosfwd>

#include "calot/scene/scene.h"

namespace calot {

/// Reads a scene. Files that it names are relative to it; only poses (CSV) are opened here, the rest by `load_tissue`
/// and `load_surface`. Throws InputError naming file and line for everything that is wrong.
Scene read_scene(const std::filesystem::path& path);

/// Writes a scene in metres that reads back the same. Files are named as they are in `scene`.
void write_scene(std::ostream& out, const Scene& scene);

}  // namespace calot
