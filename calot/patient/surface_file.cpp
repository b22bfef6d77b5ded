#include "calot/patient/surface_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <ostream>

#include "calot/base/files.h"

namespace calot::detail {
namespace {

template <class T>
void append(std::string& out, T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  out.append(bytes.data(), bytes.size());
}

void append_floats(std::string& out, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) append(out, static_cast<float>(v[axis]));
}

std::string header(const Surface& surface) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\n"
      "comment Calot surface: RAS millimetres; normals and triplanar texture weights of the rest shape\n"
      "element vertex " +
      std::to_string(surface.positions.size()) + "\n";
  for (const char* name : {"x", "y", "z"}) out += std::string("property double ") + name + "\n";
  for (const char* name : {"nx", "ny", "nz", "wx", "wy", "wz"}) out += std::string("property float ") + name + "\n";
  return out + "element face " + std::to_string(surface.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nproperty int region\nend_header\n";
}

}  // namespace

void write_textured_surface(const std::filesystem::path& path, const TexturedSurface& textured) {
  const Surface& surface = textured.surface;
  std::string bytes = header(surface);
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, surface.positions[v][axis] * 1e3);
    append_floats(bytes, textured.normals[v]);
    append_floats(bytes, textured.weights[v]);
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    append(bytes, std::uint8_t{3});
    for (const std::uint32_t corner : surface.triangles[t]) append(bytes, static_cast<std::int32_t>(corner));
    append(bytes, surface.regions.empty() ? 0 : surface.regions[t]);
  }
  write_file(path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

}  // namespace calot::detail
