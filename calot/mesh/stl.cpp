// .stl surfaces, ASCII and binary. STL has no shared vertices: corners at exactly the same place become one vertex.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/writers.h"

namespace calot::detail {
namespace {

constexpr std::size_t head_size = 84, triangle_size = 50;

/// Joins the corners (three to a triangle) that coincide; vertices keep the order of first appearance.
Surface join_corners(const std::vector<Vec3>& corners) {
  std::vector<std::uint32_t> order(corners.size()), first(corners.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    for (int i = 0; i < 3; ++i)
      if (corners[a][i] != corners[b][i]) return corners[a][i] < corners[b][i];
    return a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && corners[order[i]] == corners[order[i - 1]] ? first[order[i - 1]] : order[i];
  Surface surface;
  std::vector<std::uint32_t> number(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (first[i] == i) {
      number[i] = static_cast<std::uint32_t>(surface.positions.size());
      surface.positions.push_back(corners[i]);
    }
    if (i % 3 == 0) surface.triangles.emplace_back();
    surface.triangles.back()[i % 3] = number[first[i]];
  }
  return surface;
}

std::vector<Vec3> read_binary(Cursor& in) {
  in.set_binary(true);
  in.set_big_endian(false);
  in.take(80, "the header");
  const auto announced = in.value<std::uint32_t>("the number of triangles");
  const std::size_t count = in.checked_count(announced, triangle_size, "triangles");
  check_size(3 * std::uint64_t{count}, 0, in);
  std::vector<Vec3> corners;
  corners.reserve(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    in.take(12, "a normal");
    for (int c = 0; c < 3; ++c) {
      Vec3& p = corners.emplace_back();
      for (int axis = 0; axis < 3; ++axis) p[axis] = in.finite(in.value<float>("a coordinate"), "a coordinate");
    }
    in.take(2, "an attribute");
  }
  if (!in.at_end()) in.fail(std::to_string(in.remaining()) + " bytes follow the last triangle");
  return corners;
}

void expect(Cursor& in, std::string_view word) {
  if (const std::string_view found = in.token("a word"); found != word)
    in.fail(in_quotes(word) + " expected, not " + in_quotes(found));
}

/// facet normal x y z / outer loop / three vertices / endloop / endfacet; several solids may follow one another.
std::vector<Vec3> read_ascii(Cursor& in) {
  std::vector<Vec3> corners;
  while (in.skip_space()) {
    expect(in, "solid");
    in.rest_of_line();
    for (std::string_view word = in.token("facet or endsolid"); word != "endsolid";
         word = in.token("facet or endsolid")) {
      if (word != "facet") in.fail("\"facet\" or \"endsolid\" expected, not " + in_quotes(word));
      expect(in, "normal");
      for (int axis = 0; axis < 3; ++axis) in.number<double>("a normal");
      expect(in, "outer");
      expect(in, "loop");
      for (int c = 0; c < 3; ++c) {
        expect(in, "vertex");
        Vec3 p;
        for (int axis = 0; axis < 3; ++axis) p[axis] = in.coordinate("a coordinate");
        corners.push_back(p);
      }
      expect(in, "endloop");
      expect(in, "endfacet");
    }
    in.rest_of_line();
  }
  check_size(corners.size(), 0, in);
  return corners;
}

Vec3 unit_normal(const Surface& surface, const Triangle& t) {
  const std::vector<Vec3>& p = surface.positions;
  const Vec3 normal = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
  const double length = normal.stableNorm();
  return length > 0 && std::isfinite(length) ? Vec3(normal / length) : Vec3(Vec3::Zero());
}

}  // namespace

/// Binary files may begin with "solid" too; only their size tells them apart.
Surface parse_stl(std::string_view bytes, const std::string& name, double scale) {
  Cursor in(bytes, name);
  const std::size_t announced = bytes.size() < head_size ? 0 : [&] {
    return std::size_t{load<std::uint32_t>(bytes.data() + 80, std::endian::native == std::endian::big)};
  }();
  const bool binary = bytes.size() >= head_size && bytes.size() == head_size + announced * triangle_size;
  const bool text = bytes.substr(0, bytes.find('\0')).size() == bytes.size() || bytes.starts_with("solid");
  if (text && !binary) return finish_surface(join_corners(read_ascii(in)), name, scale);
  return finish_surface(join_corners(read_binary(in)), name, scale);
}

std::string format_stl(const Surface& surface, bool binary, const std::string& name) {
  std::string out;
  if (binary) {
    out = "Calot surface";  // must not begin with "solid"
    out.resize(80, ' ');
    append_bytes(out, static_cast<std::uint32_t>(surface.triangles.size()));
  } else {
    out = "solid calot\n";
  }
  const auto narrow = [&](double value) {
    if (!(std::abs(value) <= std::numeric_limits<float>::max()))
      throw InputError(name, "coordinates too large for binary .stl", "write .ply, .obj or ASCII .stl");
    return static_cast<float>(value);
  };
  for (const Triangle& t : surface.triangles) {
    const Vec3 normal = unit_normal(surface, t);
    if (binary) {
      for (const double x : normal) append_bytes(out, narrow(x));
      for (const std::uint32_t v : t)
        for (const double x : surface.positions[v]) append_bytes(out, narrow(x));
      append_bytes(out, std::uint16_t{0});
      continue;
    }
    out += "facet normal ";
    append_line(out, normal.x(), normal.y(), normal.z());
    out += "outer loop\n";
    for (const std::uint32_t v : t) {
      const Vec3& p = surface.positions[v];
      out += "vertex ";
      append_line(out, p.x(), p.y(), p.z());
    }
    out += "endloop\nendfacet\n";
  }
  return binary ? out : out + "endsolid calot\n";
}

}  // namespace calot::detail
