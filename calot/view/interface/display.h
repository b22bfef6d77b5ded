// Inside this room only: what stands around the picture while one operates.
#pragma once
#include "calot/view/interface/style.h"
#include "calot/view/interface/text.h"

namespace calot::detail {

/// Everything that drawing needs.
struct Pen {
  ImDrawList* list = nullptr;
  const Palette& palette;
  const Measures& m;
  const Fonts& fonts;
  const TextTable& texts;
  const InterfaceState& state;

  void text(ImFont* font, ImVec2 at, ImU32 color, const std::string& words) const;
  [[nodiscard]] static float width(const ImFont* font, const std::string& words);
  /// Width beside the round field that is free between two heights of the picture, margins taken off.
  [[nodiscard]] float free_width(float top, float bottom) const;
};

// Marks, in a square of this size at its top left corner.
void draw_caution(const Pen& pen, ImVec2 at, float size);  ///< triangle with an exclamation mark
void draw_alarm(const Pen& pen, ImVec2 at, float size);    ///< octagon with an exclamation mark
void draw_note(const Pen& pen, ImVec2 at, float size);     ///< circle with an i
void draw_energy(const Pen& pen, ImVec2 at, float size);   ///< lightning
void draw_blood(const Pen& pen, ImVec2 at, float size);    ///< full drop
void draw_bile(const Pen& pen, ImVec2 at, float size);     ///< hollow drop
void draw_clip(const Pen& pen, ImVec2 at, float size);
void draw_mouse(const Pen& pen, ImVec2 at, float size, const std::string& part);
/// A key as a cap with what is printed on it. @return its width
float draw_key(const Pen& pen, ImFont* font, ImVec2 at, const std::string& name);
float key_width(const Pen& pen, ImFont* font, const std::string& name);
/// As on a cap: "p" is P, "f1" is F1.
std::string printed(const std::string& name);

/// Steps, hands, fluids, time, messages.
void draw_display(const Pen& pen);
/// Where the commands of the display stand, for the mouse: which, and its rectangle.
struct CommandPlace {
  InterfaceCommand command;
  ImVec2 low, high;
};
std::vector<CommandPlace> draw_commands(const Pen& pen);

/// The words of a line of keys.
const std::string& words_of(const Pen& pen, const InterfaceControl& control);
Text text_of(InterfaceCommand command, const InterfaceState& state);

}  // namespace calot::detail
