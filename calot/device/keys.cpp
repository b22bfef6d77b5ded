#include "calot/device/keys.h"

#include <array>

namespace calot {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz", digits = "0123456789";
constexpr std::array function_names = {"f1"sv, "f2"sv, "f3"sv, "f4"sv,  "f5"sv,  "f6"sv,
                                       "f7"sv, "f8"sv, "f9"sv, "f10"sv, "f11"sv, "f12"sv};
// From Key::space on.
constexpr std::array other_names = {"space"sv,      "tab"sv,         "escape"sv,     "enter"sv,        "backspace"sv,
                                    "insert"sv,     "delete"sv,      "home"sv,       "end"sv,          "page up"sv,
                                    "page down"sv,  "up"sv,          "down"sv,       "left"sv,         "right"sv,
                                    "left shift"sv, "right shift"sv, "left ctrl"sv,  "right ctrl"sv,   "left alt"sv,
                                    "right alt"sv,  "minus"sv,       "equals"sv,     "comma"sv,        "period"sv,
                                    "slash"sv,      "semicolon"sv,   "mouse left"sv, "mouse middle"sv, "mouse right"sv};
static_assert(static_cast<int>(Key::space) + static_cast<int>(other_names.size()) == key_count);

}  // namespace

std::string_view name_of(Key key) {
  const auto from = [&](Key first) { return static_cast<std::size_t>(key) - static_cast<std::size_t>(first); };
  if (key == Key::none || static_cast<int>(key) >= key_count) return "";
  if (key <= Key::z) return letters.substr(from(Key::a), 1);
  if (key <= Key::digit_9) return digits.substr(from(Key::digit_0), 1);
  if (key <= Key::f12) return function_names[from(Key::f1)];
  return other_names[from(Key::space)];
}

std::optional<Key> key_of(std::string_view name) {
  for (int k = 1; k < key_count; ++k)
    if (name_of(static_cast<Key>(k)) == name) return static_cast<Key>(k);
  return {};
}

}  // namespace calot
