// Inside this room only: the pages over the picture: pause, settings, keys, a question.
#pragma once
#include "calot/view/interface/display.h"

namespace calot::detail {

enum class Page : std::uint8_t { none, settings, help, restart };

/// Which page is open, and what its buttons asked for.
class Pages {
 public:
  void open(Page page) { page_ = page, opened_ = true; }
  [[nodiscard]] Page page() const { return page_; }
  /// A key of a command went down, or its button was pressed.
  void take(InterfaceCommand command, const InterfaceState& state, InterfaceActions& actions);
  /// The page that is open, or the pause's if nothing is; nothing while one operates.
  void draw(const Pen& pen, InterfaceActions& actions);

 private:
  void close(InterfaceActions& actions);
  void begin(const Pen& pen, Text title, float width);
  bool button(const Pen& pen, Text text, InterfaceCommand command, float width);
  void draw_pause(const Pen& pen, InterfaceActions& actions);
  void draw_question(const Pen& pen, InterfaceActions& actions);
  void draw_settings(const Pen& pen, InterfaceActions& actions);
  void draw_devices(const Pen& pen) const;
  void draw_help(const Pen& pen, InterfaceActions& actions);

  Page page_ = Page::none;
  bool opened_ = false;      // in this picture
  bool was_paused_ = false;  // in the last one
};

}  // namespace calot::detail
