// .ply surfaces, ASCII and binary of either byte order; a face property "region" carries the regions.
#include <algorithm>
#include <optional>

#include "calot/mesh/number_text.h"
#include "calot/mesh/raw_mesh.h"
#include "calot/mesh/vtk_arrays.h"
#include "calot/mesh/writers.h"

namespace calot::detail {
namespace {

struct Property {
  std::string name;
  ScalarType type = ScalarType::float64;
  std::optional<ScalarType> count_type;  // of a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

std::optional<ScalarType> ply_type(std::string_view name) {
  if (name == "char" || name == "int8") return ScalarType::int8;
  if (name == "uchar" || name == "uint8") return ScalarType::uint8;
  if (name == "short" || name == "int16") return ScalarType::int16;
  if (name == "ushort" || name == "uint16") return ScalarType::uint16;
  if (name == "int" || name == "int32") return ScalarType::int32;
  if (name == "uint" || name == "uint32") return ScalarType::uint32;
  if (name == "float" || name == "float32") return ScalarType::float32;
  if (name == "double" || name == "float64") return ScalarType::float64;
  return std::nullopt;
}

class PlyReader {
 public:
  PlyReader(std::string_view bytes, const std::string& name) : in_(bytes, name) {}
  Surface read();

 private:
  void read_head();
  void read_format();
  void read_property(Element& element);
  ScalarType read_type();
  void read_element(const Element& element);
  void read_vertex(const Element& element);
  void read_face(const Element& element);
  void skip_row(const Element& element);
  double number(ScalarType type);
  std::size_t list_size(ScalarType type, ScalarType item);
  void check_vertex(const Element& element);

  Cursor in_;
  Surface surface_;
  std::vector<Element> elements_;
  bool binary_ = false, big_endian_ = false, has_regions_ = false;
};

double PlyReader::number(ScalarType type) {
  if (!binary_) return in_.number<double>("a number");
  switch (type) {
    case ScalarType::int8:
      return in_.value<std::int8_t>("a number");
    case ScalarType::uint8:
      return in_.value<std::uint8_t>("a number");
    case ScalarType::int16:
      return in_.value<std::int16_t>("a number");
    case ScalarType::uint16:
      return in_.value<std::uint16_t>("a number");
    case ScalarType::int32:
      return in_.value<std::int32_t>("a number");
    case ScalarType::uint32:
      return in_.value<std::uint32_t>("a number");
    case ScalarType::float32:
      return in_.value<float>("a number");
    default:
      return in_.value<double>("a number");
  }
}

std::size_t PlyReader::list_size(ScalarType type, ScalarType item) {
  const double size = number(type);
  if (!(size >= 0 && size < 1e9) || size != std::floor(size)) in_.fail("a list of " + std::to_string(size) + " items");
  return in_.checked_count(static_cast<std::uint64_t>(size), binary_ ? bytes_of(item) : 2, "list items");
}

ScalarType PlyReader::read_type() {
  const std::string_view word = in_.token_on_line();
  const auto type = ply_type(word);
  if (!type) in_.fail("unknown data type " + in_quotes(word), "use float, double, int or uchar");
  return *type;
}

void PlyReader::read_property(Element& element) {
  Property property;
  const std::size_t start = in_.position();
  if (in_.token_on_line() == "list") {
    property.count_type = read_type();
  } else {
    in_.seek(start);
  }
  property.type = read_type();
  property.name = in_.token_on_line();
  element.properties.push_back(property);
}

void PlyReader::read_format() {
  const std::string_view format = in_.token_on_line();
  if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
    in_.fail("format " + in_quotes(format) + ", not ascii or binary", "save it as ascii or binary .ply");
  binary_ = format != "ascii";
  big_endian_ = format == "binary_big_endian";
}

void PlyReader::read_head() {
  if (in_.rest_of_line() != "ply") in_.fail("not a .ply file: it doesn't begin with \"ply\"");
  bool has_format = false;
  while (true) {
    const std::string_view keyword = in_.token("the header's end");
    if (keyword == "end_header") break;
    if (keyword == "format") {
      read_format();
      has_format = true;
    } else if (keyword == "element") {
      Element& element = elements_.emplace_back();
      element.name = in_.token_on_line();
      element.count = in_.number_in<std::uint64_t>(in_.token_on_line(), "a number of elements");
      check_size(element.count, 0, in_);
    } else if (keyword == "property") {
      if (elements_.empty()) in_.fail("a property before the first element");
      read_property(elements_.back());
    } else if (keyword != "comment" && keyword != "obj_info") {
      in_.fail("unknown keyword " + in_quotes(keyword));
    }
    in_.rest_of_line();
  }
  in_.rest_of_line();
  if (!has_format) in_.fail("no format line");
  in_.set_binary(binary_);
  in_.set_big_endian(big_endian_);
}

void PlyReader::check_vertex(const Element& element) {
  for (const char* axis : {"x", "y", "z"})
    if (std::none_of(element.properties.begin(), element.properties.end(),
                     [&](const Property& p) { return p.name == axis && !p.count_type; }))
      in_.fail(std::string("vertices without the property ") + axis);
}

void PlyReader::read_vertex(const Element& element) {
  Vec3 p = Vec3::Zero();
  for (const Property& property : element.properties) {
    const std::size_t items = property.count_type ? list_size(*property.count_type, property.type) : 1;
    for (std::size_t i = 0; i < items; ++i) {
      const double value = number(property.type);
      if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z' && !property.count_type)
        p[property.name[0] - 'x'] = in_.finite(value, "a coordinate");
    }
  }
  surface_.positions.push_back(p);
}

/// Polygons become fans of triangles around their first corner.
void PlyReader::read_face(const Element& element) {
  std::vector<std::uint32_t> corners;
  std::int32_t region = 0;
  for (const Property& property : element.properties) {
    const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
    const std::size_t items = property.count_type ? list_size(*property.count_type, property.type) : 1;
    for (std::size_t i = 0; i < items; ++i) {
      const double value = number(property.type);
      if (property.name == "region" && !property.count_type) {
        region = to_region(value, in_);
        has_regions_ = true;
      }
      if (!is_corners || !property.count_type) continue;
      if (!(value >= 0 && value < 4294967295.0) || value != std::floor(value))
        in_.fail("vertex number " + std::to_string(value));
      corners.push_back(static_cast<std::uint32_t>(value));
    }
  }
  if (corners.size() < 3) in_.fail("a face with " + std::to_string(corners.size()) + " corners");
  for (std::size_t c = 2; c < corners.size(); ++c) {
    surface_.triangles.push_back({corners[0], corners[c - 1], corners[c]});
    surface_.regions.push_back(region);
  }
}

void PlyReader::skip_row(const Element& element) {
  for (const Property& property : element.properties) {
    const std::size_t items = property.count_type ? list_size(*property.count_type, property.type) : 1;
    for (std::size_t i = 0; i < items; ++i) number(property.type);
  }
}

void PlyReader::read_element(const Element& element) {
  if (element.properties.empty()) return;
  in_.set_section("element " + in_quotes(element.name));
  const std::size_t count = in_.checked_count(element.count, binary_ ? 1 : 2, "elements");
  if (element.name == "vertex") check_vertex(element);
  for (std::size_t i = 0; i < count; ++i) {
    if (element.name == "vertex")
      read_vertex(element);
    else if (element.name == "face")
      read_face(element);
    else
      skip_row(element);
  }
}

Surface PlyReader::read() {
  read_head();
  for (const Element& element : elements_) read_element(element);
  check_size(surface_.positions.size(), surface_.triangles.size(), in_);
  if (!has_regions_) surface_.regions.clear();
  return std::move(surface_);
}

}  // namespace

Surface parse_ply(std::string_view bytes, const std::string& name, double scale) {
  return finish_surface(PlyReader(bytes, name).read(), name, scale);
}

std::string format_ply(const Surface& surface, bool binary) {
  std::string out =
      std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") + " 1.0\ncomment Calot surface\n";
  out += "element vertex " + std::to_string(surface.positions.size()) + "\n";
  out += "property double x\nproperty double y\nproperty double z\n";
  out += "element face " + std::to_string(surface.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
  const bool regions = !surface.regions.empty();
  if (regions) out += "property int region\n";
  out += "end_header\n";
  for (const Vec3& p : surface.positions) {
    if (!binary) append_line(out, p.x(), p.y(), p.z());
    for (int axis = 0; binary && axis < 3; ++axis) append_bytes(out, p[axis]);
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& v = surface.triangles[t];
    if (binary) {
      append_bytes(out, std::uint8_t{3});
      for (const std::uint32_t corner : v) append_bytes(out, static_cast<std::int32_t>(corner));
      if (regions) append_bytes(out, surface.regions[t]);
    } else if (regions) {
      append_line(out, 3, v[0], v[1], v[2], surface.regions[t]);
    } else {
      append_line(out, 3, v[0], v[1], v[2]);
    }
  }
  return out;
}

}  // namespace calot::detail
