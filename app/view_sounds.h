// What a running scene sounds like: cues and levels from its snapshots.
#pragma once
#include <map>
#include <span>
#include <vector>

#include "calot/sound/sound_scene.h"
#include "calot/view/camera.h"
#include "calot/view/snapshot.h"

namespace calot {

class ViewSounds {
 public:
  /// Once for each snapshot: what it has new makes the cues.
  void update(const Snapshot& snapshot, const Camera& camera);
  [[nodiscard]] const SoundScene& scene() const { return scene_; }
  [[nodiscard]] std::span<const SoundCue> cues() const { return cues_; }

 private:
  void hear_instrument(std::size_t number, const InstrumentSnapshot& tool, const Camera& camera);
  void hear_event(const WorldEvent& event, const Snapshot& snapshot, const Camera& camera);

  SoundScene scene_;
  std::vector<SoundCue> cues_;
  std::vector<double> openings_;  // of the instruments, in the snapshot before [rad]
  double sucked_ = 0;
};

}  // namespace calot
