#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/bench.h"

namespace calot::bench {
namespace {

using Json = nlohmann::ordered_json;

Json number(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const Row& row) {
  return {{"name", row.name},
          {"value", row.value},
          {"unit", row.unit},
          {"p50", number(row.p50)},
          {"p99", number(row.p99)},
          {"max", number(row.max)},
          {"baseline", row.baseline.empty() ? Json(nullptr) : Json(row.baseline)},
          {"ratio", number(row.ratio)},
          {"goal", number(row.goal)},
          {"goal_ratio", number(row.goal_ratio)}};
}

std::string text(const std::optional<double>& value) {
  if (!value) return "";
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", *value);
  return buffer.data();
}

/// Characters, not bytes, so that columns line up.
std::size_t width(const std::string& utf8) {
  return static_cast<std::size_t>(
      std::count_if(utf8.begin(), utf8.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

using Line = std::vector<std::string>;

std::string align(const std::vector<Line>& lines) {
  std::vector<std::size_t> widths(lines.front().size());
  for (const Line& line : lines)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], width(line[c]));
  std::string table;
  for (const Line& line : lines) {
    std::string row;
    for (std::size_t c = 0; c < line.size(); ++c) {
      const std::string space(widths[c] - width(line[c]), ' ');
      const bool left = c == 0 || c + 1 >= line.size() || c == 2;
      row += (c > 0 ? "  " : "") + (left ? line[c] + space : space + line[c]);
    }
    table += row.substr(0, row.find_last_not_of(' ') + 1) + '\n';
  }
  return table;
}

}  // namespace

std::string to_json(const Report& report) {
  const Machine& m = report.machine;
  Json json;
  json["machine"] = {{"processor", m.processor}, {"cores", m.cores}, {"threads", m.threads},
                     {"memory_gb", m.memory_gb}, {"blas", m.blas},   {"compiler", m.compiler},
                     {"system", m.system}};
  json["rows"] = Json::array();
  for (const Row& row : report.rows) json["rows"].push_back(json_of(row));
  return json.dump(2) + '\n';
}

std::string to_text(const Report& report) {
  const Machine& m = report.machine;
  std::vector<Line> lines{{"", "value", "", "p50", "p99", "max", "goal", "ratio", "goal", "met", "ratio to"}};
  for (const Row& r : report.rows)
    lines.push_back({r.name, text(r.value), r.unit, text(r.p50), text(r.p99), text(r.max), text(r.goal), text(r.ratio),
                     text(r.goal_ratio), r.goal || r.goal_ratio ? (met(r) ? "yes" : "NO") : "", r.baseline});
  return m.processor + ", " + std::to_string(m.cores) + " cores, " + std::to_string(m.threads) + " threads; " + m.blas +
         "; " + m.compiler + '\n' + align(lines);
}

}  // namespace calot::bench
