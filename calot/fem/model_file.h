// model.toml: a mesh file, materials, supports and a step. DESIGN of the keys: docs/formats.md.
#pragma once
#include <filesystem>

#include "calot/fem/model.h"

namespace calot {

/// Reads model.toml and the mesh it names (relative to the file). Throws InputError naming file and line: unknown keys,
/// E ≤ 0, ν outside (−1, 0.5), ρ ≤ 0, regions or vertices that aren't there, a static model without fixed vertices …
Model load_model(const std::filesystem::path& path);

/// Writes a model.toml that loads to the same model, beside a mesh already written as `mesh_name` in metres.
/// Supports are written as vertex numbers.
void save_model(const std::filesystem::path& path, const Model& model, const std::string& mesh_name);

}  // namespace calot
