// Labels in one piece, without holes, and with smooth outlines where they were ragged.
#pragma once
#include <set>

#include "calot/patient/label_edit.h"

namespace calot {

/// Cleans every structure but those in `leave`, on the labels' own grid:
/// - parts other than the largest go; tubes may hang together by corners, as thin ones do in coarse voxels, and layers
///   by strips of neighbouring slices that lie up to a slice's thickness or so apart;
/// - enclosed holes up to `largest_hole` are filled;
/// - an organ whose surface is ragged (`ragged_above`) becomes its opened-and-closed self; tubes, which an opening
/// could
///   break, are closed only. Nothing is taken from another structure, and a smooth one stays as it is.
/// Fat, bed and wall, which are thin layers, keep their outlines.
void clean_labels(WorkLabels& labels, const CompletionOptions& options, const std::set<Structure>& leave,
                  std::vector<CompletionStep>& steps, Progress& progress);

}  // namespace calot
