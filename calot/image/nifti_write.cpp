#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/image/nifti.h"

// Written by hand, not by ITK: ITK can't write header extensions, and the same volume must give the same bytes.
namespace calot {
namespace {

constexpr std::size_t header_size = 348;

template <class T>
void put(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

std::string escaped(const std::string& text) {
  std::string xml;
  for (const char c : text) {
    if (c == '&')
      xml += "&amp;";
    else if (c == '<')
      xml += "&lt;";
    else if (c == '>')
      xml += "&gt;";
    else
      xml += c;
  }
  return xml;
}

/// The quaternion form, for tools that don't know the other one.
void put_qform(std::string& header, const VoxelGrid& grid) {
  Eigen::Matrix3d axes = grid.to_world.linear() * grid.spacing().cwiseInverse().asDiagonal();
  const bool turned = axes.determinant() < 0;
  if (turned) axes.col(2) *= -1;
  Eigen::Quaterniond q(axes);
  if (q.w() < 0) q.coeffs() *= -1;
  put<std::int16_t>(header, 252, 1);
  put<float>(header, 76, turned ? -1.0f : 1.0f);
  for (int d = 0; d < 3; ++d) {
    put<float>(header, 256 + 4 * static_cast<std::size_t>(d), static_cast<float>(q.vec()[d]));
    put<float>(header, 268 + 4 * static_cast<std::size_t>(d), static_cast<float>(1e3 * grid.to_world.translation()[d]));
  }
}

/// @param datatype  NIFTI_TYPE_…: 4 int16, 512 uint16
std::string make_header(const VoxelGrid& grid, std::int16_t datatype, std::size_t extensions) {
  std::string header(header_size, '\0');
  put<std::int32_t>(header, 0, header_size);
  put<std::int16_t>(header, 40, 3);
  for (std::size_t d = 0; d < 7; ++d) {
    if (d < 3 && grid.size[d] > 32767)
      throw FailedError("", "NIfTI-1 can't hold more than 32767 voxels along an axis", "resample");
    put<std::int16_t>(header, 42 + 2 * d, d < 3 ? static_cast<std::int16_t>(grid.size[d]) : std::int16_t{1});
    put<float>(header, 80 + 4 * d, d < 3 ? static_cast<float>(1e3 * grid.spacing()[static_cast<int>(d)]) : 1.0f);
  }
  put<std::int16_t>(header, 70, datatype);
  put<std::int16_t>(header, 72, 16);
  put<float>(header, 108, static_cast<float>(header_size + 4 + extensions));
  put<float>(header, 112, 1.0f);
  put<std::uint8_t>(header, 123, 2);  // millimetres
  put_qform(header, grid);
  put<std::int16_t>(header, 254, 1);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      put<float>(header, static_cast<std::size_t>(280 + 16 * row + 4 * column),
                 static_cast<float>(1e3 * grid.to_world(row, column)));
  std::memcpy(header.data() + 344, "n+1", 4);
  return header;
}

/// Deflates pieces into a stream; zlib's own gzip wrapper has no time stamp in it.
void write_packed(std::ostream& out, std::span<const std::string_view> pieces) {
  z_stream stream{};
  constexpr int level = 4;  // on noisy CT as small as level 6 (32.2 against 32.5 of 60.4 MB) in a quarter of its time
  if (deflateInit2(&stream, level, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw FailedError("", "no memory to compress");
  std::vector<char> chunk(1 << 18);
  for (std::size_t p = 0; p <= pieces.size(); ++p) {
    const bool last = p == pieces.size();
    std::string_view piece = last ? std::string_view() : pieces[p];
    do {
      const std::size_t part = std::min<std::size_t>(piece.size(), std::size_t{1} << 30);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
      stream.avail_in = static_cast<uInt>(part);
      piece.remove_prefix(part);
      do {
        stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
        stream.avail_out = static_cast<uInt>(chunk.size());
        deflate(&stream, last ? Z_FINISH : Z_NO_FLUSH);
        out.write(chunk.data(), static_cast<std::streamsize>(chunk.size() - stream.avail_out));
      } while (stream.avail_out == 0);
    } while (!piece.empty());
  }
  deflateEnd(&stream);
}

void write_nifti(const std::filesystem::path& path, const VoxelGrid& grid, std::int16_t datatype,
                 const std::string& extensions, std::string_view voxels) {
  const bool packed = path.extension() == ".gz";
  if (!packed && path.extension() != ".nii")
    throw InputError(path.string(), "isn't named .nii or .nii.gz", "name it so");
  const std::string header = make_header(grid, datatype, extensions.size());
  const std::string mark(extensions.empty() ? std::string(4, '\0') : std::string("\1\0\0\0", 4));
  const std::array<std::string_view, 4> pieces{header, mark, extensions, voxels};
  write_file(path, [&](std::ostream& out) {
    if (packed) return write_packed(out, pieces);
    for (const std::string_view piece : pieces) out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
  });
}

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace

std::string label_names_extension(const std::map<Label, std::string>& names) {
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<CaretExtension><VolumeInformation Index=\"0\"><LabelTable>\n";
  for (const auto& [label, name] : names)
    xml += "<Label Key=\"" + std::to_string(label) + "\">" + escaped(name) + "</Label>\n";
  xml += "</LabelTable></VolumeInformation></CaretExtension>\n";
  std::string extension(8, '\0');
  extension += xml;
  extension.resize((extension.size() + 15) / 16 * 16, '\0');
  put<std::int32_t>(extension, 0, static_cast<std::int32_t>(extension.size()));
  put<std::int32_t>(extension, 4, 30);  // NIFTI_ECODE_CARET
  return extension;
}

void write_label_map(const std::filesystem::path& path, const LabelMap& map) {
  write_nifti(path, map.grid, 512, map.names.empty() ? std::string() : label_names_extension(map.names),
              bytes_of(map.voxels));
}

void write_ct(const std::filesystem::path& path, const CtImage& ct) {
  write_nifti(path, ct.grid, 4, {}, bytes_of(ct.hounsfield));
}

}  // namespace calot
