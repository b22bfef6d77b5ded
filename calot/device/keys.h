// Keys and mouse buttons by the names that people and files use.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace calot {

/// A key by what is printed on it, or a button of the mouse. The letters, digits and function keys follow one another.
enum class Key : std::uint8_t {
  none,
  a,
  z = a + 25,
  digit_0,
  digit_9 = digit_0 + 9,
  f1,
  f12 = f1 + 11,
  space,
  tab,
  escape,
  enter,
  backspace,
  insert,
  delete_key,
  home,
  end,
  page_up,
  page_down,
  up,
  down,
  left,
  right,
  left_shift,
  right_shift,
  left_ctrl,
  right_ctrl,
  left_alt,
  right_alt,
  minus,
  equals,
  comma,
  period,
  slash,
  semicolon,
  mouse_left,
  mouse_middle,
  mouse_right,
};
constexpr int key_count = static_cast<int>(Key::mouse_right) + 1;

constexpr Key key_of_letter(char lower) {
  return static_cast<Key>(static_cast<int>(Key::a) + (lower - 'a'));
}
constexpr Key key_of_digit(int digit) {
  return static_cast<Key>(static_cast<int>(Key::digit_0) + digit);
}
constexpr Key function_key(int number) {
  return static_cast<Key>(static_cast<int>(Key::f1) + number - 1);
}

/// "w", "7", "f1", "space", "left ctrl", "mouse right" …; "" for none.
std::string_view name_of(Key key);
std::optional<Key> key_of(std::string_view name);

}  // namespace calot
