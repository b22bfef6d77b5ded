#include "calot/view/interface/embedded.h"

extern "C" {
extern const unsigned char calot_english_begin[], calot_english_end[], calot_font_begin[], calot_font_end[];
}

namespace calot::detail {

std::string_view embedded_english() {
  return {reinterpret_cast<const char*>(calot_english_begin),
          static_cast<std::size_t>(calot_english_end - calot_english_begin)};
}

std::span<const unsigned char> embedded_font() {
  return {calot_font_begin, calot_font_end};
}

}  // namespace calot::detail
