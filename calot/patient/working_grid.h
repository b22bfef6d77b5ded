// The grid that a patient is worked on: fine, isotropic, along the CT's axes, around the structures.
#pragma once
#include "calot/patient/label_edit.h"

namespace calot {

/// A grid and how it came about.
struct WorkingGrid {
  VoxelGrid grid;
  bool same_voxels = false;  ///< its voxels are the source's, only fewer of them
  std::string detail;        ///< in words
  std::string warning;       ///< where it is coarser than it should be; else empty
};

/// Chooses the grid: the source's own voxels where they are isotropic (5 %) and at most 1 mm, else `options.spacing`;
/// finer (0.4 mm at the finest) where the thinnest tube, drawn or labelled, needs it to be 2.2 voxels wide. It covers
/// labels and lines with `options.margin` around, within the source's volume. Where that makes more than 80 million
/// voxels, the finest spacing that doesn't is taken, with a warning.
WorkingGrid choose_working_grid(const WorkLabels& labels, const VoxelGrid& source, const std::vector<Centreline>& lines,
                                const CompletionOptions& options);

/// The labels on another grid with parallel axes, by their shapes: the signed distance of each structure is
/// interpolated (Catmull-Rom) and the largest inside wins, so that thick slices don't become terraces. Along an axis
/// with coarse voxels distances count threefold, because outlines shift from slice to slice by more than a slice's
/// thickness. The level of each surface is set so that the structure keeps its volume. Source: shape-based
/// interpolation [Raya1990], here in 3-D.
WorkLabels resample_labels(const WorkLabels& labels, const WorkingGrid& to, Progress& progress);

/// The CT on another grid, trilinear; beyond the outermost voxel centres their values go on.
CtImage resample_ct(const CtImage& ct, const VoxelGrid& grid, Progress& progress);

/// What resampling changed against taking the nearest voxel, as steps.
void report_resampling(const WorkLabels& before, const WorkLabels& after, const std::string& detail,
                       std::vector<CompletionStep>& steps);

}  // namespace calot
