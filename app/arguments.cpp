#include "app/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace {

/// One comma-separated value: a number, and what stands behind it.
struct Value {
  double number = 0;
  std::string unit;
};

Value parse_value(const std::string& word, const std::string& where) {
  const std::size_t skip = word.starts_with('+') ? 1 : 0;
  Value value;
  const char* end = word.data() + word.size();
  const auto [rest, code] = std::from_chars(word.data() + skip, end, value.number);
  if (code != std::errc() || !std::isfinite(value.number))
    throw InputError(where, "\"" + word + "\" is not a finite number", "write e.g. 0.01 or 10mm");
  value.unit.assign(rest, end);
  return value;
}

std::vector<Value> parse_list(const std::string& text, std::size_t count, const std::string& where,
                              const std::string& form) {
  std::vector<Value> values;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t comma = std::min(text.find(',', start), text.size());
    values.push_back(parse_value(text.substr(start, comma - start), where + " " + text));
    start = comma + 1;
  }
  if (values.size() != count)
    throw InputError(where + " " + text,
                     "has " + std::to_string(values.size()) + " values, not " + std::to_string(count), "write " + form);
  return values;
}

/// Lengths in metres. Units must be on all of them or none: in 10mm,5,0 the 5 could mean either.
std::vector<double> lengths(const std::vector<Value>& values, const std::string& where) {
  const bool any_unit = std::any_of(values.begin(), values.end(), [](const Value& v) { return !v.unit.empty(); });
  std::vector<double> metres;
  for (const Value& value : values) {
    if (any_unit && value.unit.empty() && value.number != 0)
      throw InputError(where, "some lengths have a unit and some don't", "give all of them one");
    metres.push_back(value.unit.empty() ? value.number : value.number * metres_per(value.unit, where));
  }
  return metres;
}

Vec3 direction(const std::vector<Value>& values, std::size_t first, const std::string& where) {
  Vec3 vector;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!values[first + axis].unit.empty())
      throw InputError(where, "a direction has no unit", "write its three numbers alone");
    vector[static_cast<int>(axis)] = values[first + axis].number;
  }
  return vector;
}

}  // namespace

Plane parse_plane(const std::string& text) {
  const auto values = parse_list(text, 6, "--plane", "px,py,pz,nx,ny,nz");
  const auto point = lengths({values.begin(), values.begin() + 3}, "--plane " + text);
  return {{point[0], point[1], point[2]}, direction(values, 3, "--plane " + text)};
}

BladePatch parse_blade(const std::string& text) {
  const std::string where = "--blade " + text;
  const auto values = parse_list(text, 11, "--blade", "cx,cy,cz,nx,ny,nz,ax,ay,az,length,width");
  const auto metres = lengths({values[0], values[1], values[2], values[9], values[10]}, where);
  return {{metres[0], metres[1], metres[2]},
          direction(values, 3, where),
          direction(values, 6, where),
          metres[3],
          metres[4]};
}

PointForce parse_force(const std::string& text) {
  const std::string where = "--force " + text;
  const auto values = parse_list(text, 4, "--force", "V,fx,fy,fz");
  const double vertex = values[0].number;
  if (!values[0].unit.empty() || vertex < 0 || vertex != std::floor(vertex) || vertex > 4e9)
    throw InputError(where, "the first value must be a vertex number", "count from 0");
  return {VertexId(static_cast<std::uint32_t>(vertex)), direction(values, 1, where)};
}

void CutArguments::add_to(CLI::App& command) {
  add_repeated(command, "--plane", planes,
               "px,py,pz,nx,ny,nz: cut along a plane; point in m, or with units (10mm,0,0,1,0,0)", false);
  add_repeated(command, "--blade", patches,
               "cx,cy,cz,nx,ny,nz,ax,ay,az,length,width: cut with a rectangle around a centre", false);
  command.add_option("--region", region, "cut only this region (name or number)")->type_name("NAME");
  command.add_flag("--clean", clean, "also remove tetrahedra left hanging by a vertex or an edge, or alone");
}

std::vector<Blade> CutArguments::blades() const {
  if (planes.empty() && patches.empty())
    throw InputError("--plane", "nothing says where to cut", "give at least one --plane or --blade");
  std::vector<Blade> all;
  for (const std::string& plane : planes) all.emplace_back(parse_plane(plane));
  for (const std::string& patch : patches) all.emplace_back(parse_blade(patch));
  return all;
}

std::string CutArguments::name_of(std::size_t blade) const {
  return blade < planes.size() ? "--plane " + planes[blade] : "--blade " + patches.at(blade - planes.size());
}

void add_repeated(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                  const std::string& description, bool required) {
  command.add_option(name, values, description + " (repeatable)")
      ->allow_extra_args(false)
      ->required(required)
      ->type_name("TEXT");
}

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

void check_output_file(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (std::filesystem::is_directory(path, code)) throw InputError(path.string(), "is a folder", "name a file to write");
  if (!std::filesystem::is_directory(folder, code))
    throw InputError(path.string(), "its folder does not exist", "make " + folder.string() + " first");
}

void check_forces(const std::vector<PointForce>& forces, const Model& model) {
  for (const PointForce& force : forces) {
    const std::size_t vertex = force.vertex.index();
    if (vertex >= model.mesh().vertex_count())
      throw InputError("--force", "vertex " + std::to_string(vertex) + " is not in the mesh",
                       "use 0 to " + std::to_string(model.mesh().vertex_count() - 1));
  }
}

void warn_about_idle(const std::vector<PointForce>& forces, const Model& model) {
  for (const PointForce& force : forces)
    if (model.is_fixed(force.vertex))
      warn("vertex " + std::to_string(force.vertex.value) + " is fixed: a force on it does nothing");
}

void make_output_folder(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code || !std::filesystem::is_directory(folder))
    throw FailedError(folder.string(), "can't be made", "give another folder");
  if (!std::filesystem::is_empty(folder))
    throw InputError(folder.string(), "holds something already", "give an empty or a new folder");
}

}  // namespace calot
