// A table of poses with anything in it: poses that are finite and in order, or an InputError.
#include <cstddef>
#include <cstdint>

#include "calot/base/error.h"
#include "calot/scene/pose_file.h"
#include "tests/support/files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const calot::test::TempFolder folder;
  calot::test::write_bytes(folder / "p.csv", {reinterpret_cast<const char*>(data), size});
  try {
    const calot::InstrumentScript script = calot::read_poses(folder / "p.csv", 1e-3);
    for (const double time : {0.0, 0.5 * script.end(), script.end()})
      if (!calot::input_at(script, 0.02, {}, time).pose.position.allFinite()) __builtin_trap();
  } catch (const calot::InputError&) {
    return 0;
  }
  return 0;
}
