// A synthetic patient: nothing needs downloading, and the truth is known.
#pragma once
#include <cstdint>
#include <vector>

#include "calot/base/progress.h"
#include "calot/patient/label_map.h"
#include "calot/patient/markups.h"

namespace calot {

namespace phantom_label {
constexpr Label gallbladder = 2, cystic_duct = 3, common_bile_duct = 4;
}

/// What was drawn by the seed: lengths [m], volume [m³]. Ranges and sources: docs/patient.md.
struct PhantomFacts {
  double gallbladder_length = 0, gallbladder_width = 0, gallbladder_volume = 0;
  double cystic_duct_length = 0;  ///< along the middle, from the gallbladder's neck to the wall of the bile duct
  double cystic_duct_diameter = 0;
  double bile_duct_length = 0;  ///< below the junction; the common hepatic duct goes on above it, under the same label
  double bile_duct_diameter = 0, hepatic_duct_length = 0;
};

struct Phantom {
  LabelMap labels;
  CtImage ct;                     ///< native CT: bile in fat, with noise and partial volume, on the labels' grid
  std::vector<Centreline> ducts;  ///< "cystic duct" (neck to junction), "common bile duct" (hilum to papilla)
  PhantomFacts facts;
};

/// Makes the biliary tree of an adult: gallbladder, cystic duct, common bile duct with the common hepatic duct above
/// it. RAS metres, the junction of the ducts at the origin; gallbladder to the right, in front and below. The same seed
/// and voxel size give the same phantom, on any number of threads.
/// @param voxel  edge of a voxel [m], 0.3e-3 … 0.7e-3 (the thinnest duct, 2.4 mm, needs 3.5 voxels or more)
/// Throws InputError for a voxel size out of range.
Phantom make_phantom(std::uint64_t seed, double voxel = 0.6e-3, Progress* progress = nullptr);

}  // namespace calot
