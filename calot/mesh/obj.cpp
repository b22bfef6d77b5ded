// Wavefront .obj surfaces: v and f lines; groups named region_N carry the regions.
#include <optional>

#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"

namespace calot::detail {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& name) : in_(bytes, name) {}
  Surface read();

 private:
  void read_vertex();
  void read_face();
  void read_group();
  std::uint32_t vertex_of(std::string_view corner);

  Cursor in_;
  Surface surface_;
  std::int32_t region_ = 0;
  bool has_regions_ = false;
};

void ObjReader::read_vertex() {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis)
    p[axis] = in_.finite(in_.number_in<double>(in_.token_on_line(), "a coordinate"), "a coordinate");
  surface_.positions.push_back(p);
}

/// "v", "v/vt", "v//vn" or "v/vt/vn"; counts from 1, or from the end when negative.
std::uint32_t ObjReader::vertex_of(std::string_view corner) {
  const auto number = in_.number_in<std::int64_t>(corner.substr(0, corner.find('/')), "a vertex number");
  const auto n = static_cast<std::int64_t>(surface_.positions.size());
  if (number == 0 || number > n || number < -n)
    in_.fail("vertex " + std::to_string(number) + " of " + std::to_string(n) + " so far");
  return static_cast<std::uint32_t>(number > 0 ? number - 1 : n + number);
}

/// Polygons become fans of triangles around their first corner.
void ObjReader::read_face() {
  std::vector<std::uint32_t> corners;
  for (std::string_view word = in_.token_on_line(); !word.empty(); word = in_.token_on_line())
    corners.push_back(vertex_of(word));
  if (corners.size() < 3) in_.fail("a face with " + std::to_string(corners.size()) + " corners");
  for (std::size_t c = 2; c < corners.size(); ++c) {
    surface_.triangles.push_back({corners[0], corners[c - 1], corners[c]});
    surface_.regions.push_back(region_);
  }
}

void ObjReader::read_group() {
  constexpr std::string_view prefix = "region_";
  const std::string_view group = in_.token_on_line();
  region_ = 0;
  if (!group.starts_with(prefix)) return;
  std::int32_t number = 0;
  const auto [end, code] = std::from_chars(group.data() + prefix.size(), group.data() + group.size(), number);
  if (code != std::errc() || end != group.data() + group.size()) return;  // somebody else's name
  region_ = number;
  has_regions_ = true;
}

Surface ObjReader::read() {
  while (in_.skip_space()) {
    const std::string_view keyword = in_.token("a keyword");
    if (keyword == "v") read_vertex();
    if (keyword == "f") read_face();
    if (keyword == "g") read_group();
    in_.rest_of_line();  // normals, textures, materials and comments are none of our business
    check_size(surface_.positions.size(), surface_.triangles.size(), in_);
  }
  if (!has_regions_) surface_.regions.clear();
  return std::move(surface_);
}

}  // namespace

Surface parse_obj(std::string_view bytes, const std::string& name, double scale) {
  return finish_surface(ObjReader(bytes, name).read(), name, scale);
}

std::string format_obj(const Surface& surface) {
  std::string out = "# Calot surface\n";
  for (const Vec3& p : surface.positions) {
    out += "v ";
    append_line(out, p.x(), p.y(), p.z());
  }
  std::optional<std::int32_t> region;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (!surface.regions.empty() && region != surface.regions[t]) {
      region = surface.regions[t];
      out += "g region_" + std::to_string(*region) + "\n";
    }
    const Triangle& v = surface.triangles[t];
    out += "f ";
    append_line(out, v[0] + 1, v[1] + 1, v[2] + 1);
  }
  return out;
}

}  // namespace calot::detail
