// A hand without hardware that holds one of a scene's instruments, for `calot simulate --haptic-mock`.
#pragma once
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "calot/scene/scene_world.h"
#include "calot/sim/haptic_loop.h"
#include "calot/sim/haptic_mock.h"

namespace calot {

/// The mock wants the handle where the scene's script has the instrument; the haptic loop runs at 1 kHz on its own
/// thread, against the clock. So the world is kept at the clock's pace too.
class MockHolder {
 public:
  /// Throws InputError for a scene without [haptics].
  MockHolder(const Scene& scene, const SceneRun& run);

  /// Waits for the next step's time, and puts what the loop says into the instrument's place.
  void take(SceneRun::Inputs& inputs);
  /// After the step: hands the constraints to the loop.
  void give(const World& world);

  [[nodiscard]] std::string text() const;
  [[nodiscard]] nlohmann::ordered_json json() const;

 private:
  std::size_t instrument_;
  std::string name_;
  std::chrono::duration<double> period_;
  MockHapticDevice device_;
  HapticLoop loop_;
  std::chrono::steady_clock::time_point next_;
  double peak_ = 0;                                                 // force shown [N]
  std::uint64_t late_ = 0, stale_ = 0, limited_ = 0, refused_ = 0;  // steps
};

}  // namespace calot
