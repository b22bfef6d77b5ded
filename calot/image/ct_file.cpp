#include "calot/image/ct_file.h"

#include <algorithm>

#include "calot/base/error.h"
#include "calot/base/memory.h"
#include "calot/base/parallel.h"
#include "calot/image/dicom_series.h"
#include "calot/image/nifti.h"
#include "calot/image/nrrd.h"
#include "calot/image/text.h"

namespace calot {
namespace fs = std::filesystem;
namespace {

CtFile read_nifti_ct(const fs::path& path, Progress& progress) {
  progress.phase("reading the CT");
  ByteSource source(path);
  const NiftiHeader header = read_nifti_header(source);
  NumberReader numbers(source, header.stored, header.grid.count());
  return {{header.grid, read_hounsfield(numbers, progress)}, "NIfTI", {path.string()}, {}};
}

CtFile read_nrrd_ct(const fs::path& path, Progress& progress) {
  progress.phase("reading the CT");
  NrrdFile file = open_nrrd(path);
  if (file.header.components != 1)
    throw InputError(path.string(), "has " + std::to_string(file.header.components) + " numbers a voxel, not one",
                     "export one volume of Hounsfield units");
  NumberReader numbers(*file.source, file.header.stored, file.header.grid.count());
  CtFile ct{{file.header.grid, read_hounsfield(numbers, progress)}, "NRRD", {path.string()}, {}};
  if (file.data != path) ct.inputs.push_back(file.data.string());
  return ct;
}

CtFile read_series(DicomSeries series, const std::string& where, std::vector<std::string> notes, Progress& progress) {
  CtFile file;
  file.format = "DICOM";
  file.notes = std::move(notes);
  file.ct.grid = order_slices(series, where, file.notes);
  require_memory(file.ct.grid.count() * sizeof(std::int16_t), "the CT's voxels");
  progress.phase("reading DICOM slices");
  file.ct.hounsfield.resize(file.ct.grid.count());
  const std::size_t slice_voxels = file.ct.grid.size[0] * file.ct.grid.size[1];
  constexpr std::size_t at_a_time = 16;  // decoding compressed slices takes most of the time
  for (std::size_t first = 0; first < series.slices.size(); first += at_a_time) {
    const std::size_t count = std::min(at_a_time, series.slices.size() - first);
    parallel_for(count, [&](std::size_t k) {
      read_dicom_pixels(series.slices[first + k], file.ct.hounsfield.data() + (first + k) * slice_voxels);
    });
    progress.at(static_cast<double>(first + count) / static_cast<double>(series.slices.size()));
  }
  for (const DicomSlice& slice : series.slices) file.inputs.push_back(slice.path.string());
  return file;
}

CtFile read_dicom_folder(const fs::path& folder, bool deep, Progress& progress, const std::string& wanted) {
  std::vector<std::string> notes;
  auto all = find_series(folder, deep, progress, notes);
  DicomSeries series = choose_series(std::move(all), folder.string(), wanted, notes);
  return read_series(std::move(series), folder.string(), std::move(notes), progress);
}

CtFile read_dicom_file(const fs::path& path, Progress& progress, const std::string& wanted) {
  ByteSource there(path);  // says so where it is missing or can't be opened
  const auto slice = read_dicom_header(path);
  if (!slice)
    throw InputError(path.string(), "is no CT image that can be read",
                     "give a folder of DICOM files, .nii, .nii.gz, .nrrd or .nhdr");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  return read_dicom_folder(folder, false, progress, wanted.empty() ? slice->series_uid : wanted);
}

void check_values(const CtFile& file, const std::string& where) {
  const auto [low, high] = std::minmax_element(file.ct.hounsfield.begin(), file.ct.hounsfield.end());
  const std::string advice = "give a CT in Hounsfield units (air about -1000, water 0)";
  if (*low == *high) throw InputError(where, "every voxel has the same value, " + std::to_string(*low), advice);
  if (*low >= -200 || *high <= 0)
    throw InputError(
        where, "its values from " + std::to_string(*low) + " to " + std::to_string(*high) + " are no HU of a body",
        advice);
}

CtFile read_any(const fs::path& path, Progress& progress, const std::string& series) {
  std::error_code code;
  if (fs::is_directory(path, code)) return read_dicom_folder(path, true, progress, series);
  const std::string name = path.filename().string();
  const bool nifti = name.ends_with(".nii") || name.ends_with(".nii.gz");
  const bool nrrd = name.ends_with(".nrrd") || name.ends_with(".nhdr");
  if ((nifti || nrrd) && !series.empty()) throw InputError("--series", "goes with DICOM only", "leave it out");
  if (nifti) return read_nifti_ct(path, progress);
  if (nrrd) return read_nrrd_ct(path, progress);
  return read_dicom_file(path, progress, series);
}

}  // namespace

CtFile read_ct(const fs::path& path, Progress& progress, const std::string& series) {
  CtFile file = read_any(path, progress, series);
  check_values(file, path.string());
  std::sort(file.inputs.begin(), file.inputs.end());
  return file;
}

}  // namespace calot
