#include "calot/scene/pose_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/toml_file.h"

namespace calot {
namespace {

constexpr std::uint64_t size_limit = std::uint64_t{64} << 20;
constexpr std::size_t columns = 12, needed = 8;
constexpr std::array<const char*, columns> names{"time", "x",  "y",       "z",    "qw",     "qx",
                                                 "qy",   "qz", "opening", "grip", "energy", "fire"};

std::vector<std::string> fields_of(std::string line) {
  std::vector<std::string> fields;
  std::replace(line.begin(), line.end(), '\r', ' ');
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) {
    const auto first = field.find_first_not_of(" \t"), last = field.find_last_not_of(" \t");
    fields.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
  }
  return fields;
}

/// For each column of the file, which of `names` it is.
std::vector<std::size_t> header_of(const std::vector<std::string>& fields, const std::string& where) {
  std::vector<std::size_t> header;
  for (const std::string& field : fields) {
    const auto found = std::find(names.begin(), names.end(), field);
    if (found == names.end())
      throw InputError(where, "there is no column \"" + detail::brief(field) + "\"",
                       detail::suggestion(field, {names.begin(), names.end()}));
    const auto number = static_cast<std::size_t>(found - names.begin());
    if (std::find(header.begin(), header.end(), number) != header.end())
      throw InputError(where, "the column " + field + " is there twice", "give it once");
    header.push_back(number);
  }
  for (std::size_t i = 0; i < needed; ++i)
    if (std::find(header.begin(), header.end(), i) == header.end())
      throw InputError(where, std::string("the column ") + names[i] + " is missing",
                       "begin with the line time,x,y,z,qw,qx,qy,qz");
  return header;
}

double number_of(const std::string& field, const std::string& where) {
  double value = 0;
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (code != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
    throw InputError(where, "\"" + detail::brief(field) + "\" is not a finite number", "write e.g. 1.5");
  return value;
}

void need_range(double value, const char* name, double low, double high, const std::string& where) {
  if (value < low || value > high)
    throw InputError(where, std::string(name) + " = " + detail::short_number(value) + " is out of range",
                     "give " + detail::short_number(low) + " to " + detail::short_number(high));
}

InstrumentPoseKey key_of(const std::array<double, columns>& v, double metres, const std::string& where) {
  InstrumentPoseKey key;
  need_range(v[0], "time", 0, 1e5, where);
  for (std::size_t i = 1; i < 4; ++i) need_range(metres * v[i], names[i], -10, 10, where);
  need_range(v[8], "opening", 0, 180, where);
  need_range(v[9], "grip", 0, 1000, where);
  const Eigen::Quaterniond q(v[4], v[5], v[6], v[7]);
  if (std::abs(q.norm() - 1) > 0.01)
    throw InputError(where, "qw, qx, qy, qz are no rotation: their length is " + detail::short_number(q.norm()),
                     "give a unit quaternion");
  key.time = v[0];
  key.pose = {q.normalized(), metres * Vec3(v[1], v[2], v[3])};
  key.opening = M_PI / 180 * v[8];
  key.grip = v[9];
  key.energy = v[10] != 0;
  key.fire = v[11] != 0;
  return key;
}

}  // namespace

InstrumentScript read_poses(const std::filesystem::path& path, double metres) {
  std::istringstream in(read_file(path, size_limit));
  InstrumentScript script;
  std::vector<std::size_t> header;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    const std::string where = at_line(path.string(), number);
    const std::vector<std::string> fields = fields_of(line);
    if (fields.empty() || (fields.size() == 1 && fields[0].empty())) continue;
    if (header.empty()) {
      header = header_of(fields, where);
      continue;
    }
    if (fields.size() != header.size())
      throw InputError(where,
                       std::to_string(fields.size()) + " values for " + std::to_string(header.size()) + " columns",
                       "give one for each");
    std::array<double, columns> values{};
    for (std::size_t i = 0; i < fields.size(); ++i) values[header[i]] = number_of(fields[i], where);
    script.poses.push_back(key_of(values, metres, where));
    if (script.poses.size() > 1 && script.poses[script.poses.size() - 2].time >= script.poses.back().time)
      throw InputError(where, "the time doesn't grow", "order the lines by time");
  }
  if (script.poses.empty()) throw InputError(path.string(), "has no poses", "add a header line and one line a pose");
  return script;
}

}  // namespace calot
