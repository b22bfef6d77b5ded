// From bodies to voxels.
#pragma once
#include "calot/patient/phantom_abdomen.h"
#include "calot/patient/phantom_field.h"

namespace calot {

/// Cubic voxels close around liver and ducts, as far as the skin in front; or the whole trunk by `matrix`.
VoxelGrid phantom_grid(const PhantomOptions& options, const OperatingField& field, const Abdomen& abdomen);

/// Fills the phantom's labels and CT, both on the grid it has. A voxel gets the label of the organ that holds its
/// centre, and its HU from the shares that organs have in it; noise is a function of seed and voxel number, so threads
/// don't matter.
void paint_field(const OperatingField& field, const Abdomen& abdomen, std::uint64_t seed, Phantom& phantom,
                 Progress& progress);

/// Makes every tube whole: sets the voxels along its middle line, where a tube thinner than two voxels can miss voxel
/// centres, but never those of organs that win over it.
void trace_tubes(const OperatingField& field, LabelMap& labels);

/// Each label one part, joined through faces; pockets without a label that organs enclose go to the one they touch
/// most.
void clean_labels(LabelMap& labels);

}  // namespace calot
