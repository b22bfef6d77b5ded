#include "calot/view/passes/models_drawn.h"

#include <Eigen/Geometry>

namespace calot::detail {
namespace {

Eigen::Matrix4f matrix_of(const Pose& pose) {
  Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
  m.block<3, 3>(0, 0) = pose.rotation.toRotationMatrix().cast<float>();
  m.block<3, 1>(0, 3) = pose.position.cast<float>();
  return m;
}

/// Changes when a clip's legs move against each other.
double shape_key(const RigidShape& shape) {
  double key = 0;
  for (const RoundedPiece& piece : shape.pieces)
    for (int c = 0; c < piece.corner_count; ++c)
      key = 1.7 * key + piece.corners[static_cast<std::size_t>(c)].sum() + piece.radius;
  return std::abs(key) + 1;
}

}  // namespace

void ModelsDrawn::set_surroundings(std::span<const Surface> surfaces) {
  surroundings_.clear();
  for (const Surface& surface : surfaces) surroundings_.emplace_back(part_of(surface));
  cavity_.reset();
}

const ModelsDrawn::Instrument& ModelsDrawn::instrument(InstrumentKind kind) {
  const auto found = instruments_.find(kind);
  if (found != instruments_.end()) return found->second;
  Instrument made{instrument_geometry(kind), {}};
  for (const ModelPart& part : instrument_model(made.geometry)) made.parts.push_back({part.frame, StillMesh(part)});
  return instruments_.emplace(kind, std::move(made)).first->second;
}

void ModelsDrawn::add_instrument(const Snapshot& snapshot, std::size_t index, std::vector<Drawable>& drawables) {
  const InstrumentSnapshot& tool = snapshot.instruments[index];
  const Instrument& model = instrument(tool.kind);
  const ArticulatedPoses poses = articulate(model.geometry, tool.opening);
  for (const Part& part : model.parts) {
    const Pose& inner = part.frame == ModelFrame::jaw_a   ? poses.jaw_a
                        : part.frame == ModelFrame::jaw_b ? poses.jaw_b
                                                          : poses.shaft;
    Drawable d = part.mesh.drawable();
    d.pose = matrix_of(tool.pose * inner);
    drawables.push_back(d);
  }
  if (!shows_loaded_clip(snapshot, index)) return;
  if (loaded_.size() <= index) loaded_.resize(index + 1);
  Changing& loaded = loaded_[index];
  if (loaded.key != tool.opening || !loaded.mesh) {
    loaded.mesh.emplace(loaded_clip_model(model.geometry, tool.opening));
    loaded.key = tool.opening;
  }
  Drawable d = loaded.mesh->drawable();
  d.pose = matrix_of(tool.pose * poses.shaft);
  drawables.push_back(d);
}

void ModelsDrawn::add_clip(const ClipSnapshot& clip, std::size_t index, std::vector<Drawable>& drawables) {
  if (clip.state == ClipState::off) return;
  if (clips_.size() <= index) clips_.resize(index + 1);
  Changing& drawn = clips_[index];
  const double key = shape_key(clip.shape);
  if (drawn.key != key) {
    drawn.mesh.emplace(clip_model(clip));
    drawn.key = key;
  }
  Drawable d = drawn.mesh->drawable();
  d.pose = matrix_of(clip.frame);
  drawables.push_back(d);
}

void ModelsDrawn::add_cavity(const Snapshot& snapshot, std::vector<Drawable>& drawables) {
  if (!cavity_) {
    Eigen::AlignedBox3f box;
    for (const SkinVertex& v : snapshot.skin.vertices) box.extend(v.rest);
    const Vec3f middle = box.isEmpty() ? Vec3f::Zero() : Vec3f(box.center());
    const float reach = box.isEmpty() ? 0 : 0.5F * box.diagonal().norm();
    cavity_.emplace(cavity_dome(middle, std::max(0.16F, reach + 0.08F)));
  }
  Drawable d = cavity_->drawable();
  d.kind = SurfaceKind::cavity;
  d.casts_shadow = false;
  d.two_sided = true;
  drawables.push_back(d);
}

void ModelsDrawn::add_to(const Snapshot& snapshot, std::vector<Drawable>& drawables) {
  for (std::size_t k = 0; k < snapshot.instruments.size(); ++k) add_instrument(snapshot, k, drawables);
  for (std::size_t k = 0; k < snapshot.clips.size(); ++k) add_clip(snapshot.clips[k], k, drawables);
  for (const StillMesh& mesh : surroundings_) {
    Drawable d = mesh.drawable();
    d.kind = SurfaceKind::cavity;
    d.two_sided = true;
    drawables.push_back(d);
  }
  if (surroundings_.empty()) add_cavity(snapshot, drawables);
}

}  // namespace calot::detail
