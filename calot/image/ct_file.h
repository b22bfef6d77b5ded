// CT images from files: DICOM series, NIfTI and NRRD.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/image/volume.h"

namespace calot {

/// A CT with what was noticed on the way.
struct CtFile {
  CtImage ct;                       ///< RAS [m]; any orientation of the voxel axes
  std::string format;               ///< "DICOM", "NIfTI", "NRRD"
  std::vector<std::string> inputs;  ///< every file that was read, sorted; for provenance
  std::vector<std::string> notes;   ///< for the log: series chosen, files of other series left out …
};

/// Reads a CT in Hounsfield units: a folder holding a DICOM series (also one file of it; also compressed: JPEG 2000,
/// JPEG lossless, RLE), .nii, .nii.gz, .nrrd or .nhdr. Values are rescaled by the file's slope and intercept and
/// rounded to whole HU, clamped to −32768 … 32767. Slices may come in any file order. Throws InputError naming file and
/// field: missing or unreadable files, a folder without DICOM, several series (lists them: number of slices,
/// description; `series` picks one), another modality than CT, missing slices (says between which positions),
/// inconsistent slice spacing (more than 2 % or 0.05 mm), slices of different size or orientation, a tilted gantry
/// (shear), colour or multi-component pixels, 4-D, values that are no HU (every voxel the same, or none below −200 or
/// none above 0: says what range there is).
/// @param series  SeriesInstanceUID (or its beginning, or a number of the list) of the series to read; empty: the only.
///     For DICOM only: refused for other files
CtFile read_ct(const std::filesystem::path& path, Progress& progress, const std::string& series = {});

}  // namespace calot
