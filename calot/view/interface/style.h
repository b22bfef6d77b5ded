// Inside this room only: sizes, colours and letters of the interface.
#pragma once
#include <imgui.h>

#include <set>
#include <string>

#include "calot/view/interface/interface_state.h"

namespace calot::detail {

/// Colour-blind people tell these apart [Okabe2008]; nothing is said by colour alone.
struct Palette {
  ImU32 text, dim, line, plate, panel, left, right, caution, alarm, blood, bile;
};
Palette palette_of(InterfaceColors colors);
ImU32 with_alpha(ImU32 color, float share);
/// Relative luminance contrast of two opaque colours, 1 … 21 [Wcag2018].
double contrast(ImU32 a, ImU32 b);

/// Sizes in pixels.
struct Measures {
  float width = 0, height = 0;
  float text = 0, small = 0, large = 0;  ///< heights of letters' lines
  float margin = 0, line = 0;            ///< line: thickness of fine lines
  float radius = 0;                      ///< of the round field; 0: the picture fills everything
  friend bool operator==(const Measures&, const Measures&) = default;
};
Measures measures_of(const InterfaceState& state, int width, int height, double pixel_ratio);

/// DejaVu Sans in three sizes, with the letters that are needed; made anew when these change.
class Fonts {
 public:
  /// @return whether the atlas is a new one
  bool prepare(ImFontAtlas& atlas, const Measures& measures, const std::string& letters);
  [[nodiscard]] ImFont* text() const { return text_; }
  [[nodiscard]] ImFont* small() const { return small_; }
  [[nodiscard]] ImFont* large() const { return large_; }

 private:
  float text_size_ = 0;
  std::set<ImWchar> known_;
  ImVector<ImWchar> ranges_;
  ImFont *text_ = nullptr, *small_ = nullptr, *large_ = nullptr;
};

/// What panels look like.
void apply_style(const Palette& palette, const Measures& measures);

}  // namespace calot::detail
