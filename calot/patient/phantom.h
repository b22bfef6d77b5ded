// Synthetic patients: nothing needs downloading, and the truth is known.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "calot/base/progress.h"
#include "calot/image/label_map.h"
#include "calot/patient/centreline_file.h"
#include "calot/patient/structure.h"

namespace calot {

/// Anatomical variants, by the names of the command line: "usual", "short-cystic-duct", "low-insertion",
/// "aberrant-right-duct", "second-cystic-artery", "inflamed".
enum class PhantomVariant {
  usual,
  short_cystic_duct,     ///< 8 … 12 mm long
  low_insertion,         ///< runs down beside the bile duct and joins it low
  aberrant_right_duct,   ///< a right hepatic duct crosses Calot's triangle
  second_cystic_artery,  ///< a second artery, behind the duct
  inflamed,              ///< wall of 4 … 7 mm as a region of its own, oedema in the fat around
};
std::string_view name_of(PhantomVariant variant);
std::optional<PhantomVariant> variant_named(std::string_view name);

struct PhantomOptions {
  std::uint64_t seed = 1;
  PhantomVariant variant = PhantomVariant::usual;
  double voxel = 0.7e-3;  ///< edge of the (cubic) voxels [m], 0.3e-3 … 1.0e-3
  /// A whole abdominal CT of so many voxels over the torso (columns, rows, slices), instead of cubic voxels close
  /// around the liver.
  std::optional<std::array<std::size_t, 3>> matrix = {};
};

/// What was drawn by the seed: lengths [m], volumes [m³]. Ranges and sources: docs/patient.md. 0 where it isn't there.
struct PhantomFacts {
  double liver_volume = 0, liver_width = 0, liver_depth = 0, liver_height = 0;
  double gallbladder_length = 0, gallbladder_width = 0, gallbladder_volume = 0, wall_thickness = 0;
  double cystic_duct_length = 0;  ///< along the middle, from the gallbladder's neck to the wall of the bile duct
  double cystic_duct_diameter = 0;
  double bile_duct_length = 0;  ///< below the junction
  double bile_duct_diameter = 0, hepatic_duct_length = 0;
  double cystic_artery_length = 0, cystic_artery_diameter = 0;
};

struct Phantom {
  LabelMap labels;
  CtImage ct;                     ///< on the labels' grid, with noise and partial volume
  std::vector<Centreline> lines;  ///< of every tube, named as structures, along the flow
  PhantomFacts facts;
};

/// Makes the whole operating field of an adult: liver, pear-shaped gallbladder in its bed, cystic duct, common hepatic
/// and common bile duct, right hepatic and cystic artery, fat in Calot's triangle and the bed, in an abdomen. RAS
/// metres, the junction of the ducts at the origin. Labels are Structure numbers. The same options give the same
/// phantom on any number of threads. Throws InputError for options out of range.
Phantom make_phantom(const PhantomOptions& options, Progress& progress);

/// The biliary tree alone, in fat: gallbladder, cystic duct and common bile duct (with the common hepatic duct above
/// the junction under the same label), labels 2, 3, 4, as in the published experiments that Calot starts from.
/// @param voxel  edge of a voxel [m], 0.3e-3 … 0.7e-3 (the thinnest duct, 2.4 mm, needs 3.5 voxels or more)
Phantom make_biliary_tree(std::uint64_t seed, double voxel = 0.6e-3, Progress* progress = nullptr);

}  // namespace calot
