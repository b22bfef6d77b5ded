// Inside this room only: the figures of a region that a scene may set, with their ranges.
#pragma once
#include <span>

#include "calot/base/toml_file.h"
#include "calot/fem/element.h"
#include "calot/sim/tissue_properties.h"

namespace calot::detail {

/// One figure; of the material or of the properties.
struct RegionFigure {
  const char* key;
  double low, high;  ///< SI; lengths are read in the file's unit
  const char* unit;
  double Material::*material;
  double TissueProperties::*property;
  bool is_length = false;
};
std::span<const RegionFigure> region_figures();
const RegionFigure* region_figure(std::string_view key);

}  // namespace calot::detail
