// Inside this room only. Single DICOM files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace calot {

/// What one file's header says about its image, unchecked: lengths in mm, directions and positions in LPS.
struct DicomSlice {
  std::filesystem::path path;
  std::string series_uid, instance_uid, modality, description, photometric;
  int series_number = 0, rows = 0, columns = 0, frames = 1, samples = 1;
  int bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  bool localizer = false;                ///< ImageType says that it is a scout view
  std::vector<double> position;          ///< ImagePositionPatient, 3
  std::vector<double> orientation;       ///< ImageOrientationPatient, 6: along a row, along a column
  std::vector<double> spacing;           ///< PixelSpacing, 2: between rows, between columns
  std::vector<double> slope, intercept;  ///< RescaleSlope, RescaleIntercept, 1 each
};

/// Reads the header of a file. Empty: no DICOM, or DICOM without an image of a series (DICOMDIR, reports).
/// Throws InputError for a DICOM file that ends within its header or is deflated as a whole.
std::optional<DicomSlice> read_dicom_header(const std::filesystem::path& path);

/// Decodes an image of one frame with one number a pixel into rows · columns whole HU, clamped to −32768 … 32767.
/// Throws InputError: truncated or damaged, a compression that can't be undone, numbers packed in an unusual way.
void read_dicom_pixels(const DicomSlice& slice, std::int16_t* hounsfield);

}  // namespace calot
