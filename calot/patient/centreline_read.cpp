// Reading centrelines: whatever the bytes, sound lines or an InputError.
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/toml_file.h"
#include "calot/patient/centreline_file.h"
#include "calot/patient/import_options.h"
#include "calot/patient/json_file.h"

namespace calot {
namespace {

using detail::brief;
using detail::Json;
using detail::short_number;

constexpr std::uint64_t size_limit = std::uint64_t{16} << 20;
constexpr double mm = 1e-3;
constexpr double smallest_radius = 0.2 * mm, largest_radius = 15 * mm;
constexpr double farthest_neighbour = 60 * mm;
constexpr double same_place = 1e-6;
constexpr double farthest_coordinate = 10;  // [m]: no body and no scanner is larger

/// A line as read, and for each point where it was: "FILE:LINE" or "FILE: markups[0]…".
struct FoundLine {
  Centreline line;
  std::string where;
  std::vector<std::string> point_where;
};

std::string point_text(const Vec3& p) {
  return "(" + short_number(p[0] / mm) + ", " + short_number(p[1] / mm) + ", " + short_number(p[2] / mm) + ") mm";
}

void check_point(const FoundLine& found, std::size_t p) {
  const Vec3& x = found.line.points[p];
  const double radius = found.line.radii[p];
  if (!x.allFinite() || x.cwiseAbs().maxCoeff() > farthest_coordinate)
    throw InputError(found.point_where[p], "a point at " + point_text(x) + " is in no body",
                     "give coordinates in millimetres, RAS");
  if (!(radius >= smallest_radius && radius <= largest_radius))
    throw InputError(found.point_where[p],
                     "radius " + short_number(radius / mm) + " mm is not that of a duct or an artery",
                     "give 0.2 to 15 mm");
  if (p == 0) return;
  const double step = (x - found.line.points[p - 1]).norm();
  if (step < same_place)
    throw InputError(found.point_where[p], "the point is at the same place as the one before it", "remove one of them");
  if (step > farthest_neighbour)
    throw InputError(found.point_where[p],
                     "the point is " + short_number(std::round(step / mm)) + " mm away from the one before it",
                     "put points between, 60 mm apart at most; are they in millimetres and in order?");
}

/// Everything that doesn't depend on the format.
std::vector<Centreline> checked(const std::vector<FoundLine>& found, const std::string& file) {
  if (found.empty()) throw InputError(file, "has no centreline", "draw an open curve along each duct");
  std::vector<Centreline> lines;
  std::set<std::string> names;
  for (const FoundLine& each : found) {
    if (plain_name(each.line.name).empty())
      throw InputError(each.where, "a centreline without a name", "name it after its structure, e.g. cystic duct");
    if (!names.insert(plain_name(each.line.name)).second)
      throw InputError(each.where, "a second centreline named \"" + brief(each.line.name) + "\"", "keep one of them");
    if (each.line.points.size() < 2)
      throw InputError(each.where, "\"" + brief(each.line.name) + "\" has fewer than two points", "draw it longer");
    for (std::size_t p = 0; p < each.line.points.size(); ++p) check_point(each, p);
    lines.push_back(each.line);
  }
  return lines;
}

// ---- 3D Slicer's markups ----

/// One markup; `field` is its place in the file.
class MarkupReader {
 public:
  MarkupReader(const std::string& file, const Json& markup, std::size_t number)
      : file_(file), markup_(markup), field_("markups[" + std::to_string(number) + "]") {}

  FoundLine read() {
    if (!markup_.is_object()) fail("", "is not a markup", "save it from 3D Slicer again");
    found_.where = file_ + ": " + field_;
    found_.line.name = text("name", "");
    const std::string type = text("type", "");
    if (type != "Curve" && type != "Line")
      fail("type", "\"" + brief(type) + "\" is not an open curve",
           "draw a curve (Markups, Open curve), and save it alone");
    const bool flip = is_lps();
    check_unit("coordinateUnits", markup_);
    const Json& points = list("controlPoints", markup_, field_);
    read_radii(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) read_point(points[p], p, flip);
    return std::move(found_);
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& what, const std::string& what_to_do) const {
    throw InputError(file_ + ": " + field_ + (key.empty() ? "" : "." + key), what, what_to_do);
  }

  [[nodiscard]] std::string text(const std::string& key, const std::string& otherwise) const {
    const auto found = markup_.find(key);
    if (found == markup_.end()) return otherwise;
    if (!found->is_string()) fail(key, "is not text", "save it from 3D Slicer again");
    return found->get<std::string>();
  }

  /// LPS is the schema's default; 0 and 1 are how the first version of the format said RAS and LPS.
  [[nodiscard]] bool is_lps() const {
    const auto found = markup_.find("coordinateSystem");
    if (found == markup_.end()) return true;
    const std::string system = found->is_string() ? found->get<std::string>() : found->is_number() ? found->dump() : "";
    if (system == "LPS" || system == "1") return true;
    if (system == "RAS" || system == "0") return false;
    fail("coordinateSystem", "is neither \"LPS\" nor \"RAS\"", "save the curve in patient coordinates");
  }

  void check_unit(const std::string& key, const Json& object) const {
    const auto found = object.find(key);
    if (found == object.end()) return;
    const Json& unit = found->is_array() && !found->empty() ? found->front() : *found;
    if (!unit.is_string() || unit.get<std::string>() != "mm")
      fail(key, "is not \"mm\"", "save the curve in millimetres");
  }

  [[nodiscard]] const Json& list(const std::string& key, const Json& object, const std::string& where) const {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_array())
      throw InputError(file_ + ": " + where + "." + key, "is missing or not a list", "save it from 3D Slicer again");
    return *found;
  }

  [[nodiscard]] double number(const Json& value, const std::string& key) const {
    if (!value.is_number()) fail(key, "is not a number", "correct it, or save it from 3D Slicer again");
    return value.get<double>();
  }

  /// From the first measurement named radius or diameter (any case) that has values.
  void read_radii(std::size_t points) {
    const auto measurements = markup_.find("measurements");
    if (measurements != markup_.end() && measurements->is_array())
      for (std::size_t m = 0; m < measurements->size() && radii_.empty(); ++m)
        read_measurement((*measurements)[m], m, points);
    if (radii_.empty())
      fail("measurements", "\"" + brief(found_.line.name) + "\" has no radius",
           "add a measurement \"radius\" with controlPointValues, one a point [mm], or use the text format "
           "(docs/formats.md)");
  }

  void read_measurement(const Json& measurement, std::size_t m, std::size_t points) {
    if (!measurement.is_object()) return;
    const auto name = measurement.find("name");
    if (name == measurement.end() || !name->is_string()) return;
    const std::string plain = plain_name(name->get<std::string>());
    if (plain != "radius" && plain != "diameter") return;
    const double factor = plain == "diameter" ? 0.5 * mm : mm;
    const std::string key = "measurements[" + std::to_string(m) + "]";
    if (const auto unit = measurement.find("units"); unit != measurement.end() && *unit != "mm")
      fail(key + ".units", "is not \"mm\"", "give radii in millimetres");
    if (const auto values = measurement.find("controlPointValues"); values != measurement.end()) {
      if (!values->is_array() || values->size() != points)
        fail(key + ".controlPointValues", "doesn't hold one number a control point, " + std::to_string(points),
             "give the radius at every point");
      for (const Json& value : *values) radii_.push_back(factor * number(value, key + ".controlPointValues"));
    } else if (const auto value = measurement.find("value"); value != measurement.end()) {
      radii_.assign(points, factor * number(*value, key + ".value"));
    }
  }

  void read_point(const Json& point, std::size_t p, bool flip) {
    const std::string key = "controlPoints[" + std::to_string(p) + "]";
    if (!point.is_object()) fail(key, "is not a control point", "save it from 3D Slicer again");
    if (const auto status = point.find("positionStatus"); status != point.end() && *status != "defined") return;
    const Json& position = list("position", point, field_ + "." + key);
    if (position.size() != 3) fail(key + ".position", "doesn't hold three numbers", "save it from 3D Slicer again");
    Vec3 x;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double coordinate = mm * number(position[axis], key + ".position");
      x[static_cast<int>(axis)] = flip && axis < 2 ? -coordinate : coordinate;
    }
    found_.line.points.push_back(x);
    found_.line.radii.push_back(radii_[p]);
    found_.point_where.push_back(file_ + ": " + field_ + "." + key);
  }

  const std::string& file_;
  const Json& markup_;
  std::string field_;
  FoundLine found_;
  std::vector<double> radii_;  // of every control point, defined or not
};

std::vector<FoundLine> read_markups(const std::filesystem::path& path) {
  const Json json = detail::read_json(path, size_limit);
  const std::string file = path.string();
  const auto markups = json.is_object() ? json.find("markups") : json.end();
  if (!json.is_object() || markups == json.end() || !markups->is_array())
    throw InputError(file, "holds no list \"markups\"", "save the curves from 3D Slicer as .mrk.json");
  std::vector<FoundLine> found;
  for (std::size_t m = 0; m < markups->size(); ++m) found.push_back(MarkupReader(file, (*markups)[m], m).read());
  return found;
}

// ---- the text table ----

class TableReader {
 public:
  TableReader(std::string_view bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  std::vector<FoundLine> read() {
    if (bytes_.starts_with("\xEF\xBB\xBF")) bytes_.remove_prefix(3);
    while (!bytes_.empty()) {
      const std::size_t end = bytes_.find('\n');
      std::string_view row = bytes_.substr(0, end);
      bytes_.remove_prefix(end == std::string_view::npos ? bytes_.size() : end + 1);
      ++number_;
      row = row.substr(0, row.find('#'));
      read_row(trimmed(row));
    }
    return std::move(found_);
  }

 private:
  static std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
  }
  [[nodiscard]] std::string where() const { return at_line(file_, number_); }

  void read_row(std::string_view row) {
    if (row.empty()) return;
    const std::size_t word = row.find_first_of(" \t,");
    if (row.substr(0, word) == "line") {
      FoundLine& line = found_.emplace_back();
      line.where = where();
      if (word != std::string_view::npos) line.line.name = trimmed(row.substr(word + 1));
      if (line.line.name.empty()) throw InputError(where(), "\"line\" without a name", "write e.g. line cystic duct");
      return;
    }
    if (found_.empty())
      throw InputError(where(), "a point before the first \"line\"", "begin with e.g. line cystic duct");
    add_point(row);
  }

  void add_point(std::string_view row) {
    std::array<double, 4> values{};
    std::size_t count = 0;
    while (!row.empty()) {
      const std::size_t start = row.find_first_not_of(" \t,;");
      if (start == std::string_view::npos) break;
      row.remove_prefix(start);
      const std::size_t end = row.find_first_of(" \t,;");
      const double value = number(row.substr(0, end));
      if (count < values.size()) values[count] = value;
      ++count;
      row.remove_prefix(end == std::string_view::npos ? row.size() : end);
    }
    if (count != values.size())
      throw InputError(where(), std::to_string(count) + " numbers where four belong",
                       "write x y z radius, with decimal points");
    FoundLine& line = found_.back();
    line.line.points.emplace_back(mm * values[0], mm * values[1], mm * values[2]);
    line.line.radii.push_back(mm * values[3]);
    line.point_where.push_back(where());
  }

  [[nodiscard]] double number(std::string_view text) const {
    double value = 0;
    std::string_view digits = text;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code == std::errc() && end == digits.data() + digits.size() && std::isfinite(value)) return value;
    throw InputError(where(), "\"" + brief(std::string(text)) + "\" is not a number",
                     "write x y z radius in millimetres, or line NAME");
  }

  std::string_view bytes_;
  std::string file_;
  std::size_t number_ = 0;
  std::vector<FoundLine> found_;
};

}  // namespace

std::vector<Centreline> read_centrelines(const std::filesystem::path& path) {
  const std::string file = path.string();
  if (file.ends_with(".json")) return checked(read_markups(path), file);
  if (file.ends_with(".txt") || file.ends_with(".csv")) {
    const std::string bytes = read_file(path, size_limit);
    return checked(TableReader(bytes, file).read(), file);
  }
  throw InputError(file, "is no centreline file by its ending", "use .mrk.json (3D Slicer markups), .txt or .csv");
}

}  // namespace calot
