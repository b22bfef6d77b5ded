// NIfTI files. Decoded here, not by ITK: ITK 5.2 refuses sforms whose axes are at right angles only to the seven digits
// that the file stores (docs/decisions/0003-meshing.md).
#include "calot/base/error.h"
#include "calot/image/nifti.h"

namespace calot {

NiftiHeader read_nifti_header(ByteSource& source) {
  const std::string& where = source.name();
  const bool packed = source.is_packed();
  if (packed != where.ends_with(".gz"))
    throw InputError(where, packed ? "is compressed but isn't named .nii.gz" : "is named .gz but isn't compressed",
                     "rename it");
  if (packed) source.unpack();
  std::string head(nifti_header_size, '\0');
  head.resize(source.read(head.data(), head.size()));
  NiftiHeader header = parse_nifti_header(head, where);
  std::string extensions(header.voxel_offset - nifti_header_size, '\0');
  if (source.read(extensions.data(), extensions.size()) < extensions.size())
    throw InputError(where, "is truncated: it ends within its header", "copy or export the file again");
  header.names = label_names_in_extensions(extensions, header.stored.swapped, where);
  return header;
}

LabelMap read_label_map(const std::filesystem::path& path) {
  ByteSource source(path);
  NiftiHeader header = read_nifti_header(source);
  NumberReader numbers(source, header.stored, header.grid.count());
  Progress silent;
  return {header.grid, read_labels(numbers, silent), std::move(header.names)};
}

}  // namespace calot
