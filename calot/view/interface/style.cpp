#include "calot/view/interface/style.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/view/interface/embedded.h"

namespace calot::detail {
namespace {

double linear(int value) {
  const double share = value / 255.0;
  return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

double luminance(ImU32 color) {
  return 0.2126 * linear(static_cast<int>(color & 255U)) + 0.7152 * linear(static_cast<int>((color >> 8U) & 255U)) +
         0.0722 * linear(static_cast<int>((color >> 16U) & 255U));
}

ImVec4 vector_of(ImU32 color) {
  return ImGui::ColorConvertU32ToFloat4(color);
}

/// Letters of a UTF-8 text below U+10000.
void add_letters(const std::string& text, std::set<ImWchar>& letters) {
  for (std::size_t k = 0; k < text.size();) {
    const auto first = static_cast<unsigned char>(text[k]);
    const std::size_t length = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
    unsigned code = length == 1 ? first : first & (0x7FU >> length);
    for (std::size_t i = 1; i < length && k + i < text.size(); ++i)
      code = (code << 6U) | (static_cast<unsigned char>(text[k + i]) & 0x3FU);
    if (code >= 0x20 && code < 0x10000) letters.insert(static_cast<ImWchar>(code));
    k += length;
  }
}

}  // namespace

Palette palette_of(InterfaceColors colors) {
  // Sky blue, orange, yellow, vermillion, bluish green of [Okabe2008]; for high contrast mixed with white.
  if (colors == InterfaceColors::contrast)
    return {IM_COL32(255, 255, 255, 255), IM_COL32(225, 225, 225, 255), IM_COL32(190, 190, 190, 255),
            IM_COL32(0, 0, 0, 255),       IM_COL32(0, 0, 0, 255),       IM_COL32(138, 205, 242, 255),
            IM_COL32(244, 190, 70, 255),  IM_COL32(250, 240, 100, 255), IM_COL32(255, 140, 70, 255),
            IM_COL32(255, 140, 70, 255),  IM_COL32(90, 215, 175, 255)};
  return {IM_COL32(226, 229, 232, 255), IM_COL32(150, 156, 162, 255), IM_COL32(92, 98, 104, 255),
          IM_COL32(4, 6, 8, 150),       IM_COL32(13, 16, 19, 238),    IM_COL32(86, 180, 233, 255),
          IM_COL32(230, 159, 0, 255),   IM_COL32(240, 228, 66, 255),  IM_COL32(226, 106, 20, 255),
          IM_COL32(226, 106, 20, 255),  IM_COL32(0, 158, 115, 255)};
}

ImU32 with_alpha(ImU32 color, float share) {
  const float alpha = static_cast<float>(color >> 24U) * std::clamp(share, 0.0F, 1.0F);
  return (color & 0x00FFFFFFU) | (static_cast<ImU32>(alpha + 0.5F) << 24U);
}

double contrast(ImU32 a, ImU32 b) {
  const double x = luminance(a), y = luminance(b);
  return (std::max(x, y) + 0.05) / (std::min(x, y) + 0.05);
}

Measures measures_of(const InterfaceState& state, int width, int height, double pixel_ratio) {
  Measures m;
  m.width = static_cast<float>(width);
  m.height = static_cast<float>(height);
  const double least = 11 * pixel_ratio, scaled = 0.0225 * std::min(height, width * 3 / 4);
  m.text = static_cast<float>(std::round(std::max(least, scaled) * state.settings.text_scale));
  m.small = std::max(std::round(0.82F * m.text), std::round(10 * static_cast<float>(pixel_ratio)));
  m.large = std::round(1.7F * m.text);
  m.margin = std::round(0.9F * m.text);
  m.line = std::max(1.0F, std::round(0.07F * m.text));
  m.radius = state.round_field ? round_field_radius * m.height : 0;
  return m;
}

bool Fonts::prepare(ImFontAtlas& atlas, const Measures& measures, const std::string& letters) {
  std::set<ImWchar> needed = known_;
  for (ImWchar c = 0x20; c < 0x7F; ++c) needed.insert(c);
  add_letters(letters, needed);
  if (text_ != nullptr && needed == known_ && text_size_ == measures.text) return false;
  known_ = std::move(needed);
  text_size_ = measures.text;
  ImFontGlyphRangesBuilder builder;
  for (const ImWchar c : known_) builder.AddChar(c);
  ranges_.clear();
  builder.BuildRanges(&ranges_);
  atlas.Clear();
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  config.OversampleH = measures.text < 24 ? 2 : 1;
  const auto font = embedded_font();
  const auto add = [&](float size) {
    return atlas.AddFontFromMemoryTTF(const_cast<unsigned char*>(font.data()), static_cast<int>(font.size()), size,
                                      &config, ranges_.Data);
  };
  text_ = add(measures.text);
  small_ = add(measures.small);
  large_ = add(measures.large);
  if (!atlas.Build()) throw FailedError("interface", "the font can't be read", "build Calot again");
  return true;
}

void apply_style(const Palette& palette, const Measures& m) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  const auto times = [&](float share) { return std::round(share * m.text); };  // halves of pixels make scroll bars
  style.WindowPadding = {times(1.4F), times(1.2F)};
  style.FramePadding = {times(0.8F), times(0.4F)};
  style.ItemSpacing = {times(0.7F), times(0.6F)};
  style.ScrollbarSize = times(0.7F);
  style.GrabMinSize = times(0.9F);
  style.WindowRounding = style.ChildRounding = times(0.4F);
  style.FrameRounding = style.GrabRounding = times(0.25F);
  style.WindowBorderSize = m.line;
  style.FrameBorderSize = 0;
  style.WindowMinSize = {1, 1};
  const ImVec4 accent = vector_of(palette.left), text = vector_of(palette.text), line = vector_of(palette.line);
  const auto faint = [](ImVec4 color, float alpha) {
    color.w = alpha;
    return color;
  };
  auto& colors = style.Colors;
  colors[ImGuiCol_Text] = text;
  colors[ImGuiCol_TextDisabled] = vector_of(palette.dim);
  colors[ImGuiCol_WindowBg] = colors[ImGuiCol_PopupBg] = vector_of(palette.panel);
  colors[ImGuiCol_Border] = faint(line, 0.8F);
  colors[ImGuiCol_FrameBg] = colors[ImGuiCol_Button] = faint(line, 0.28F);
  colors[ImGuiCol_FrameBgHovered] = colors[ImGuiCol_ButtonHovered] = faint(accent, 0.32F);
  colors[ImGuiCol_FrameBgActive] = colors[ImGuiCol_ButtonActive] = faint(accent, 0.5F);
  colors[ImGuiCol_SliderGrab] = colors[ImGuiCol_SliderGrabActive] = accent;
  colors[ImGuiCol_ScrollbarBg] = faint(line, 0);
  colors[ImGuiCol_ScrollbarGrab] = faint(line, 0.6F);
  colors[ImGuiCol_NavHighlight] = accent;
  colors[ImGuiCol_Separator] = faint(line, 0.5F);
}

}  // namespace calot::detail
