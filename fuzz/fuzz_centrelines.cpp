// Centrelines from any bytes, the first of which picks the format: sound lines or an InputError.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "calot/base/error.h"
#include "calot/patient/centreline_file.h"
#include "tests/support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const calot::test::TempFolder folder;
  if (size == 0) return 0;
  const auto path = folder / (data[0] % 2 == 0 ? "a.mrk.json" : "a.txt");
  calot::test::write_bytes(path, {reinterpret_cast<const char*>(data) + 1, size - 1});
  std::vector<calot::Centreline> lines;
  try {
    lines = calot::read_centrelines(path);
  } catch (const calot::InputError&) {
    return 0;
  }
  for (const calot::Centreline& line : lines) {
    if (line.points.size() < 2 || line.points.size() != line.radii.size()) std::abort();
    if (!(calot::length(line) > 0) || !std::isfinite(calot::length(line))) std::abort();
    const calot::LinePlace place = calot::place_at(line, calot::length(line) / 2);
    if (!place.point.allFinite() || !(place.radius > 0)) std::abort();
  }
  calot::write_markups(folder / "again.mrk.json", lines);
  return 0;
}
