// From segments, named or numbered by whoever drew them, to Calot's structures.
#pragma once
#include <string>
#include <vector>

#include "calot/image/segmentation.h"
#include "calot/patient/import_options.h"

namespace calot {

/// What to do where two structures share voxels.
enum class OverlapRule {
  refuse,   ///< an error that names both
  smaller,  ///< the structure with fewer voxels keeps them
};

/// What became of a segment; for the log.
struct TakenSegment {
  std::string name;                       ///< "4" where it has a number only
  Structure structure = Structure::none;  ///< none: left out
  std::size_t voxels = 0;
  double ml = 0;
};

struct StructureLabels {
  LabelMap labels;  ///< Structure numbers, names of those present
  std::vector<TakenSegment> segments;
  std::vector<std::string> warnings;  ///< segments joined to one structure, overlaps resolved, absurd volumes
};

/// Names the segments and puts them on one map. Segments of one structure (two halves of a liver) are joined.
/// @param where  the segmentation's file, for messages
/// Throws InputError: numbers without names that the table doesn't have (lists what there is: number, voxels, mL), no
/// segment of the gallbladder or of the liver (lists the names there are), structures that overlap (which, where, how
/// many voxels).
StructureLabels label_structures(const Segmentation& segmentation, const NameTable& table, OverlapRule overlaps,
                                 const std::string& where);

/// The list of segments that messages and the command show, one text each: "4: 11250 voxels, 38.2 mL".
std::vector<std::string> describe_segments(const Segmentation& segmentation);

}  // namespace calot
