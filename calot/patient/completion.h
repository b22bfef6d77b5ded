// What segmentations lack: ducts and artery from centrelines, fat and connective tissue, clean outlines, a fine grid.
#pragma once
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/image/label_map.h"
#include "calot/patient/centreline.h"
#include "calot/patient/structure.h"

namespace calot {

/// Lengths in metres, volumes in cubic metres, densities in HU. Defaults and their sources: docs/patient.md.
struct CompletionOptions {
  // resampling
  double spacing = 0.7e-3;  ///< of the working grid, isotropic, 0.3e-3 … 1e-3; finer where a thin tube needs it
  double margin = 20e-3;    ///< around all structures that is kept, 5e-3 … 100e-3
  // cleaning
  double closing = 1.0e-3;     ///< radius of the closing of ragged outlines; 0: none; ≤ 5e-3
  double ragged_above = 1.15;  ///< a label is ragged whose surface is so many times that of its opened-and-closed self
  double largest_hole = 2e-6;  ///< enclosed holes up to this are filled [m³]
  // drawing
  double overlap = 1.0e-3;    ///< tubes are prolonged into the neighbour they end at by up to this plus their radius
  double joint_reach = 6e-3;  ///< an end nearer than this to its neighbour is joined to it
  // fat and connective tissue
  bool fat = true;                                    ///< false: leave the triangle and the bed as the labels have them
  double fat_low = -150, fat_high = -20;              ///< HU of fat
  double connective_low = -20, connective_high = 60;  ///< HU of connective tissue, within `connective_reach` of …
  double connective_reach = 2e-3;                     ///< … duct, artery and gallbladder
  double triangle_reach = 5e-3;   ///< how far Calot's triangle reaches beyond the surface between its sides
  double bed_thickness = 2.5e-3;  ///< of the layer between gallbladder and liver
  double bed_reach = 5e-3;        ///< gap between gallbladder and liver that still counts as bed
};

/// One step and what it changed; for the log.
struct CompletionStep {
  std::string step;  ///< "hole filling", "closing", "drawn from its centreline" …
  Structure structure = Structure::none;
  std::size_t added = 0, removed = 0;  ///< voxels of the grid at that time
  double added_ml = 0, removed_ml = 0;
  std::string detail;  ///< in words, e.g. the thresholds
};

/// A face of the volume that cuts a structure.
struct BorderCut {
  Structure structure;
  int axis;            ///< of the CT's grid
  bool upper;          ///< at the last voxel, not the first
  Vec3 point, normal;  ///< of the cutting plane [m], RAS, pointing out of the volume
  double area;         ///< [m²]
};

struct CompletedAnatomy {
  LabelMap labels;                ///< Structure numbers on the working grid, axis-parallel to the CT's, isotropic
  CtImage ct;                     ///< resampled onto the same grid
  std::vector<Centreline> lines;  ///< of every tube that is there: given, or found in its label; named by `name_of`
  std::vector<CompletionStep> steps;
  std::vector<BorderCut> border_cuts;  ///< of liver, fat and bed (others are refused)
  std::vector<std::string> warnings;
};

/// Completes an anatomy.
/// @param labels  Structure numbers on the CT's grid
/// @param lines   tubes to draw, named as structures; a tube drawn over a label replaces that label
/// Throws InputError: grids that differ, no gallbladder, no liver, a gallbladder or duct cut by the volume's border, a
/// centreline of no known name, one that leaves the volume or the body (HU below −300 all around), or that ends farther
/// than `joint_reach` from anything it could join, no cystic duct or bile duct by label or line (says what to draw).
CompletedAnatomy complete_anatomy(const CtImage& ct, const LabelMap& labels, const std::vector<Centreline>& lines,
                                  const CompletionOptions& options, Progress& progress);

}  // namespace calot
