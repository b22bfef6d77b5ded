// Middle lines of tubes that are given as labels only.
#pragma once
#include "calot/patient/label_edit.h"

namespace calot {

/// The line through the middle of a tube's label, from one end of it to the other: a path between the two voxels that
/// are farthest apart within it, which keeps to the middle, smoothed; radii from the depth below the surface, all
/// scaled so that the tube that they sweep has the label's volume. RAS [m], points about 0.5 mm apart. The label must
/// have voxels; only the part that hangs together (by corners) with its first far end counts.
Centreline line_of_label(const WorkLabels& labels, Structure tube);

}  // namespace calot
