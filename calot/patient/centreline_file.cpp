#include "calot/patient/centreline_file.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "calot/base/files.h"

// Reading is in centreline_read.cpp.

namespace calot {
namespace {

using Json = nlohmann::ordered_json;

/// Millimetres, to the nanometre, so that reading gives the same line and a person can still read it.
double in_mm(double metres) {
  return std::round(metres * 1e9) / 1e6;
}

Json control_points(const Centreline& line) {
  Json points = Json::array();
  for (std::size_t p = 0; p < line.points.size(); ++p) {
    const Vec3& x = line.points[p];
    points.push_back({{"id", std::to_string(p + 1)},
                      {"label", line.name + "-" + std::to_string(p + 1)},
                      {"position", {in_mm(x[0]), in_mm(x[1]), in_mm(x[2])}},
                      {"selected", true},
                      {"locked", false},
                      {"visibility", true},
                      {"positionStatus", "defined"}});
  }
  return points;
}

Json curve(const Centreline& line) {
  Json radii = Json::array();
  for (const double r : line.radii) radii.push_back(in_mm(r));
  return {{"type", "Curve"},
          {"name", line.name},
          {"coordinateSystem", "RAS"},
          {"coordinateUnits", "mm"},
          {"controlPoints", control_points(line)},
          {"measurements",
           {{{"name", "length"}, {"enabled", true}, {"value", in_mm(length(line))}, {"units", "mm"}},
            {{"name", "radius"}, {"enabled", true}, {"units", "mm"}, {"controlPointValues", radii}}}}};
}

}  // namespace

void write_markups(const std::filesystem::path& path, const std::vector<Centreline>& lines) {
  Json file{{"@schema",
             "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
             "markups-schema-v1.0.3.json#"},
            {"markups", Json::array()}};
  for (const Centreline& line : lines) file["markups"].push_back(curve(line));
  write_file(path, [&](std::ostream& out) { out << file.dump(1, ' ', false, Json::error_handler_t::replace) << '\n'; });
}

}  // namespace calot
