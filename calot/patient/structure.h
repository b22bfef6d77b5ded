// The structures that Calot knows: one number and one name each, the same in every patient folder.
#pragma once
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "calot/image/label_map.h"

namespace calot {

/// Region numbers of label maps and meshes of a patient.
enum class Structure : Label {
  none = 0,
  liver = 1,
  gallbladder = 2,  ///< lumen and wall, unless the wall is a region of its own
  cystic_duct = 3,
  common_bile_duct = 4,     ///< below the cystic duct's mouth
  common_hepatic_duct = 5,  ///< above it
  cystic_artery = 6,
  right_hepatic_artery = 7,
  hepatocystic_fat = 8,  ///< fills Calot's triangle
  gallbladder_bed = 9,   ///< connective tissue between gallbladder and liver (cystic plate)
  second_cystic_artery = 10,
  aberrant_right_duct = 11,  ///< a right hepatic duct that runs through Calot's triangle
  gallbladder_wall = 12,     ///< where it is thick (inflamed)
};

/// All but none, by number.
std::span<const Structure> all_structures();
constexpr Label label_of(Structure s) {
  return static_cast<Label>(s);
}
/// "cystic duct", "common bile duct", "hepatocystic fat" …; "none".
std::string_view name_of(Structure s);
/// The inverse of `name_of`, exact.
std::optional<Structure> structure_named(std::string_view name);
/// Names for a label map's header.
std::map<Label, std::string> structure_names();

/// Ducts and arteries: what a centreline may describe.
bool is_tube(Structure s);

}  // namespace calot
