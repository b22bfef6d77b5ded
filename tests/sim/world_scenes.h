// Small worlds for the tests: a model with default tissue, instruments anywhere, and what they are told.
#pragma once
#include <optional>

#include "calot/cut/cut.h"
#include "calot/sim/world.h"
#include "tests/support/models.h"

namespace calot::test {

using Inputs = std::vector<std::optional<InstrumentInput>>;

/// Nothing but motion and contact; switch on what a test is about.
inline WorldSetup world_setup(Model model) {
  std::map<std::int32_t, TissueProperties> properties = tissue_properties(model.mesh());
  WorldSetup setup{std::move(model), std::move(properties), {}, {}, {}, {}};
  setup.options.fluids = setup.options.heat = setup.options.tearing = false;
  setup.options.gravity.setZero();
  return setup;
}

/// Tip towards `z`, the jaws' axis along `x` (made orthogonal): they open in the plane of z and z × x.
inline Eigen::Quaterniond facing(const Vec3& z, const Vec3& x) {
  Mat3 axes;
  axes.col(2) = z.normalized();
  axes.col(0) = (x - x.dot(axes.col(2)) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return Eigen::Quaterniond(axes);
}

inline InstrumentSetup instrument(InstrumentKind kind, const Vec3& at, const Vec3& towards, const Vec3& axis,
                                  double opening) {
  InstrumentSetup setup;
  setup.name = std::string(name_of(kind));
  setup.geometry = instrument_geometry(kind);
  setup.start.pose = {facing(towards, axis), at};
  setup.start.opening = opening;
  return setup;
}

/// A world that remembers all its events; those of an edit from outside count at once.
class RememberingWorld : public World {
 public:
  using World::World;
  const StepReport& step(std::span<const std::optional<InstrumentInput>> inputs) {
    const StepReport& report = World::step(inputs);
    past_.insert(past_.end(), events().begin(), events().end());
    edited_ = false;
    return report;
  }
  const StiffnessChange* edit(const TopologyEdit& edit, EventKind cause, const std::string& text,
                              std::int32_t instrument = -1) {
    edited_ = edited_ || !edit.empty();
    return World::edit(edit, cause, text, instrument);
  }
  [[nodiscard]] std::vector<WorldEvent> history() const {
    std::vector<WorldEvent> all = past_;
    if (edited_) all.insert(all.end(), events().begin(), events().end());
    return all;
  }

 private:
  std::vector<WorldEvent> past_;
  bool edited_ = false;
};

inline std::size_t count(const RememberingWorld& world, EventKind kind) {
  std::size_t sum = 0;
  for (const WorldEvent& event : world.history()) sum += event.kind == kind;
  return sum;
}

inline double fastest(const World& world) {
  double most = 0;
  for (const Vec3& v : world.state().velocities) most = std::max(most, v.norm());
  return most;
}

inline bool all_finite(const World& world) {
  for (const std::vector<Vec3>* list : {&world.state().positions, &world.state().velocities})
    for (const Vec3& v : *list)
      if (!v.allFinite()) return false;
  return true;
}

/// Where each vertex of the mesh before a step's edits is now, through all of them; none where it is gone.
inline std::vector<VertexId> followed(std::size_t vertices_before, const std::vector<StiffnessChange>& changes) {
  std::vector<VertexId> now;
  for (std::size_t v = 0; v < vertices_before; ++v) now.emplace_back(v);
  for (const StiffnessChange& change : changes)
    for (VertexId& v : now)
      if (v.valid()) v = change.remap.vertex_to_new[v.index()];
  return now;
}

}  // namespace calot::test
