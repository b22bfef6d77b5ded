// A table of keys with anything in it: settings in their ranges where each key does one thing, or an InputError.
#include <cstddef>
#include <cstdint>
#include <set>

#include "calot/base/error.h"
#include "calot/device/controls.h"
#include "tests/support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const calot::test::TempFolder folder;
  calot::test::write_bytes(folder / "k.toml", {reinterpret_cast<const char*>(data), size});
  try {
    const calot::ControlSettings settings = calot::read_controls(folder / "k.toml");
    if (!(settings.pointer_speed > 0 && settings.key_speed > 0 && settings.pad_dead_zone < 1)) __builtin_trap();
    std::set<calot::Key> seen;
    for (const calot::ActionInfo& info : calot::all_actions())
      for (const calot::Key key : settings.bindings.keys_of(info.action))
        if (!seen.insert(key).second) __builtin_trap();
    (void)settings.bindings.rows();
  } catch (const calot::InputError&) {
    return 0;
  }
  return 0;
}
