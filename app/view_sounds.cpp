#include "app/view_sounds.h"

namespace calot {
namespace {

constexpr double shut = 0.03;  // [rad]: blades that have met

SoundPosition seen(const Camera& camera, const Vec3& place) {
  const Vec3f from_eye = place.cast<float>() - camera.eye;
  return Vec3f(from_eye.dot(camera.right()), from_eye.dot(camera.up), -from_eye.dot(camera.forward)).cast<double>();
}

}  // namespace

void ViewSounds::update(const Snapshot& snapshot, const Camera& camera) {
  cues_.clear();
  scene_ = {};
  openings_.resize(snapshot.instruments.size(), 0);
  for (std::size_t k = 0; k < snapshot.instruments.size(); ++k) hear_instrument(k, snapshot.instruments[k], camera);
  for (const WorldEvent& event : snapshot.events) hear_event(event, snapshot, camera);
}

void ViewSounds::hear_instrument(std::size_t number, const InstrumentSnapshot& tool, const Camera& camera) {
  const SoundPosition place = seen(camera, tool.pose.position);
  const bool closed = openings_[number] > shut && tool.opening <= shut;
  openings_[number] = tool.opening;
  if (tool.kind == InstrumentKind::scissors && closed) cues_.push_back({SoundKind::snip, place, 1});
  if (!tool.energy) return;
  if (tool.kind == InstrumentKind::suction) {
    scene_.suction = true;
    scene_.suction_position = place;
    return;
  }
  scene_.cautery = CauteryMode::coagulate;
  scene_.cautery_power += tool.cautery;
  scene_.cautery_position = place;
}

void ViewSounds::hear_event(const WorldEvent& event, const Snapshot& snapshot, const Camera& camera) {
  SoundKind kind = SoundKind::attention;
  switch (event.kind) {
    case EventKind::clip_placed:
      kind = SoundKind::clip;
      break;
    case EventKind::grasped:
      kind = SoundKind::ratchet;
      break;
    case EventKind::let_go:
      kind = SoundKind::ratchet_release;
      break;
    case EventKind::slipped:
      kind = SoundKind::slip;
      break;
    case EventKind::torn:
      kind = SoundKind::tear;
      break;
    case EventKind::input_fault:
      kind = SoundKind::error;
      break;
    default:
      return;
  }
  SoundPosition place(0, 0, -0.1);
  if (event.instrument >= 0 && static_cast<std::size_t>(event.instrument) < snapshot.instruments.size())
    place = seen(camera, snapshot.instruments[static_cast<std::size_t>(event.instrument)].pose.position);
  cues_.push_back({kind, place, 1});
}

}  // namespace calot
