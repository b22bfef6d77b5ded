// Inside this room only. From DICOM files to the slices of one CT series in order.
#pragma once
#include "calot/base/progress.h"
#include "calot/image/dicom_files.h"
#include "calot/image/volume.h"

namespace calot {

/// The slices of one series, not yet checked.
struct DicomSeries {
  std::string uid, description, modality;
  int number = 0;
  std::vector<DicomSlice> slices;
};

/// All images of a folder (`deep`: and of the folders in it) by series, in order of number and UID.
/// @param notes  gets what was passed over
std::vector<DicomSeries> find_series(const std::filesystem::path& folder, bool deep, Progress& progress,
                                     std::vector<std::string>& notes);

/// The one CT series, or the one that `wanted` picks: a UID, its beginning, or a number of the list.
/// Throws InputError: no CT, several (lists them), no such.
DicomSeries choose_series(std::vector<DicomSeries> all, const std::string& where, const std::string& wanted,
                          std::vector<std::string>& notes);

/// Checks that the slices make one volume, sorts them along their normal and says where the voxels lie (RAS [m]).
/// Slice k of the result is layer k of the grid. Throws InputError naming file and field.
VoxelGrid order_slices(DicomSeries& series, const std::string& where, std::vector<std::string>& notes);

}  // namespace calot
