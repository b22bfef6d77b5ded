// From SDL's events to Calot's.
#pragma once
#include "calot/device/desktop.h"

union SDL_Event;

namespace calot {

/// Key::none for what Calot has no name for. Letters by what is printed on the key; on a keyboard without Latin ones by
/// where they are.
Key key_of_sdl(std::int32_t keycode, int scancode);

/// A key or a mouse button that goes down or up; none for repeats and everything else.
std::optional<KeyEvent> key_event(const SDL_Event& event);
/// @param height  of the picture, in the window's own units, > 0
std::optional<PointerEvent> pointer_event(const SDL_Event& event, int height);

/// Hands an event on, a lost focus too. @return as Desktop::key
std::optional<Action> feed(Desktop& desktop, const SDL_Event& event, int height);

}  // namespace calot
