#include "calot/patient/label_edit.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace calot {

std::size_t WorkLabels::count(Structure s) const {
  return static_cast<std::size_t>(std::count(voxels.begin(), voxels.end(), static_cast<std::uint8_t>(label_of(s))));
}

void LabelEdit::set(std::size_t v, Structure s) {
  const auto label = static_cast<std::uint8_t>(label_of(s));
  std::uint8_t& now = labels_.voxels[v];
  if (now == label) return;
  ++changes_[now].removed;
  ++changes_[label].added;
  now = label;
}

void LabelEdit::report(std::vector<CompletionStep>& steps, Structure structure, const std::string& step,
                       const std::string& detail) {
  Change& change = changes_[label_of(structure)];
  const double ml = 1e6 * labels_.grid.voxel_volume();
  if (change.added + change.removed > 0 && structure != Structure::none)
    steps.push_back({step, structure, change.added, change.removed, ml * static_cast<double>(change.added),
                     ml * static_cast<double>(change.removed), detail});
  change = {};
}

void LabelEdit::report_all(std::vector<CompletionStep>& steps, const std::string& step, const std::string& detail) {
  for (const Structure s : all_structures()) report(steps, s, step, detail);
}

std::string text_of(const char* format, ...) {
  std::array<char, 400> line{};
  va_list values;
  va_start(values, format);
  std::vsnprintf(line.data(), line.size(), format, values);
  va_end(values);
  return line.data();
}

std::string place_text(const Vec3& place) {
  return text_of("(%.1f, %.1f, %.1f) mm", 1e3 * place[0], 1e3 * place[1], 1e3 * place[2]);
}

}  // namespace calot
