#include "calot/device/sdl_events.h"

#include <SDL.h>

namespace calot {
namespace {

struct Named {
  SDL_Keycode code;
  Key key;
};
constexpr Named named[] = {
    {SDLK_SPACE, Key::space},
    {SDLK_TAB, Key::tab},
    {SDLK_ESCAPE, Key::escape},
    {SDLK_RETURN, Key::enter},
    {SDLK_KP_ENTER, Key::enter},
    {SDLK_BACKSPACE, Key::backspace},
    {SDLK_INSERT, Key::insert},
    {SDLK_DELETE, Key::delete_key},
    {SDLK_HOME, Key::home},
    {SDLK_END, Key::end},
    {SDLK_PAGEUP, Key::page_up},
    {SDLK_PAGEDOWN, Key::page_down},
    {SDLK_UP, Key::up},
    {SDLK_DOWN, Key::down},
    {SDLK_LEFT, Key::left},
    {SDLK_RIGHT, Key::right},
    {SDLK_LSHIFT, Key::left_shift},
    {SDLK_RSHIFT, Key::right_shift},
    {SDLK_LCTRL, Key::left_ctrl},
    {SDLK_RCTRL, Key::right_ctrl},
    {SDLK_LALT, Key::left_alt},
    {SDLK_RALT, Key::right_alt},
    {SDLK_MINUS, Key::minus},
    {SDLK_EQUALS, Key::equals},
    {SDLK_COMMA, Key::comma},
    {SDLK_PERIOD, Key::period},
    {SDLK_SLASH, Key::slash},
    {SDLK_SEMICOLON, Key::semicolon},
};

Key mouse_button(int button) {
  switch (button) {
    case SDL_BUTTON_LEFT:
      return Key::mouse_left;
    case SDL_BUTTON_MIDDLE:
      return Key::mouse_middle;
    case SDL_BUTTON_RIGHT:
      return Key::mouse_right;
    default:
      return Key::none;
  }
}

}  // namespace

Key key_of_sdl(std::int32_t keycode, int scancode) {
  if (keycode >= SDLK_a && keycode <= SDLK_z) return key_of_letter(static_cast<char>(keycode));
  if (keycode >= SDLK_0 && keycode <= SDLK_9) return key_of_digit(keycode - SDLK_0);
  if (keycode >= SDLK_F1 && keycode <= SDLK_F12) return function_key(keycode - SDLK_F1 + 1);
  for (const Named& entry : named)
    if (entry.code == keycode) return entry.key;
  if (scancode >= SDL_SCANCODE_A && scancode <= SDL_SCANCODE_Z)
    return key_of_letter(static_cast<char>('a' + (scancode - SDL_SCANCODE_A)));
  if (scancode >= SDL_SCANCODE_1 && scancode <= SDL_SCANCODE_9) return key_of_digit(scancode - SDL_SCANCODE_1 + 1);
  return Key::none;
}

std::optional<KeyEvent> key_event(const SDL_Event& event) {
  Key key = Key::none;
  bool down = false;
  if (event.type == SDL_KEYDOWN || event.type == SDL_KEYUP) {
    if (event.key.repeat != 0) return {};
    key = key_of_sdl(event.key.keysym.sym, event.key.keysym.scancode);
    down = event.type == SDL_KEYDOWN;
  } else if (event.type == SDL_MOUSEBUTTONDOWN || event.type == SDL_MOUSEBUTTONUP) {
    key = mouse_button(event.button.button);
    down = event.type == SDL_MOUSEBUTTONDOWN;
  }
  if (key == Key::none) return {};
  return KeyEvent{key, down};
}

std::optional<PointerEvent> pointer_event(const SDL_Event& event, int height) {
  if (event.type == SDL_MOUSEMOTION && height > 0)
    return PointerEvent{static_cast<double>(event.motion.xrel) / height,
                        static_cast<double>(event.motion.yrel) / height, 0};
  if (event.type == SDL_MOUSEWHEEL) {
    const double sign = event.wheel.direction == SDL_MOUSEWHEEL_FLIPPED ? -1 : 1;
    return PointerEvent{0, 0, sign * static_cast<double>(event.wheel.preciseY)};
  }
  return {};
}

std::optional<Action> feed(Desktop& desktop, const SDL_Event& event, int height) {
  if (event.type == SDL_WINDOWEVENT && event.window.event == SDL_WINDOWEVENT_FOCUS_LOST) desktop.let_go();
  if (const auto pointer = pointer_event(event, height)) desktop.pointer(*pointer);
  if (const auto key = key_event(event)) return desktop.key(*key);
  return {};
}

}  // namespace calot
