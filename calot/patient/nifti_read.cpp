#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkNiftiImageIO.h>

#include <cmath>

#include "calot/base/error.h"
#include "calot/patient/nifti.h"

namespace calot {
namespace {

/// Decodes the voxels. ITK's own geometry (LPS, mm) is left aside: the affine comes from the checked header, because
/// ITK takes the qform in cases where every other tool takes the sform.
template <class T>
typename itk::Image<T, 3>::Pointer decode(const std::string& path) {
  itk::Object::SetGlobalWarningDisplay(false);  // its warnings go to stderr; ours are errors with a reason
  auto reader = itk::ImageFileReader<itk::Image<T, 3>>::New();
  reader->SetImageIO(itk::NiftiImageIO::New());
  reader->SetFileName(path);
  try {
    reader->Update();
  } catch (const itk::ExceptionObject& error) {
    throw InputError(path, std::string("can't be read: ") + error.GetDescription(), "export the file again");
  }
  return reader->GetOutput();
}

template <class T>
std::vector<Label> labels_of(const std::string& path, std::size_t count) {
  const auto image = decode<T>(path);
  if (image->GetBufferedRegion().GetNumberOfPixels() != count)
    throw InputError(path, "holds another number of voxels than its header says", "export the file again");
  const T* values = image->GetBufferPointer();
  std::vector<Label> labels(count);
  for (std::size_t v = 0; v < count; ++v) {
    const auto value = static_cast<double>(values[v]);
    if (!(value >= 0 && value <= 65535) || value != std::floor(value))
      throw InputError(path,
                       "voxel " + std::to_string(v) + " has the value " + std::to_string(value) + ", which is no label",
                       "give a segmentation: whole numbers from 0 to 65535");
    labels[v] = static_cast<Label>(value);
  }
  return labels;
}

/// Whether 32-bit whole numbers hold every value of the file.
bool fits_int32(const NiftiHeader& header) {
  const int t = header.datatype;
  return header.slope == 1 && header.intercept == 0 && (t == 2 || t == 4 || t == 8 || t == 256 || t == 512);
}

}  // namespace

LabelMap read_label_map(const std::filesystem::path& path) {
  NiftiHeader header = read_nifti_header(path);
  const std::size_t count = header.grid.count();
  LabelMap map{header.grid, {}, std::move(header.names)};
  map.voxels =
      fits_int32(header) ? labels_of<std::int32_t>(path.string(), count) : labels_of<double>(path.string(), count);
  return map;
}

}  // namespace calot
