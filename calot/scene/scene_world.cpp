#include "calot/scene/scene_world.h"

#include <cmath>
#include <sstream>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/toml_file.h"
#include "calot/scene/scene_file.h"

namespace calot {
namespace {

using detail::short_number;

InstrumentGeometry geometry_of(const SceneInstrument& tool) {
  InstrumentGeometry geometry = instrument_geometry(tool.kind);
  if (tool.max_grip) geometry.max_grip = *tool.max_grip;
  return geometry;
}

/// The world would take what is beyond an instrument for a fault of a device; a scene should say it at once.
void check_reach(const SceneInstrument& tool, const InstrumentGeometry& geometry) {
  const auto check = [&](double time, double opening, double grip) {
    const std::string at = "\"" + tool.name + "\" at " + short_number(time) + " s: ";
    constexpr double degrees = 180 / M_PI, slack = 1e-9;
    if (opening > geometry.max_opening + slack)
      throw InputError(tool.where, at + "opening = " + short_number(degrees * opening) + " is more than it opens",
                       "give " + short_number(std::floor(degrees * geometry.max_opening + slack)) + " degrees at most");
    if (grip > geometry.max_grip + slack)
      throw InputError(tool.where, at + "grip = " + short_number(grip) + " is more than its strength",
                       "give " + short_number(geometry.max_grip) + " N at most, or set max_grip");
  };
  for (const InstrumentKey& key : tool.script.keys) check(key.time, key.opening, key.grip);
  for (const InstrumentPoseKey& key : tool.script.poses) check(key.time, key.opening, key.grip);
}

InstrumentSetup instrument_of(const SceneInstrument& tool, const SceneTissue& tissue) {
  InstrumentSetup setup;
  setup.name = tool.name;
  setup.geometry = geometry_of(tool);
  if (tool.script.empty()) throw InputError(tool.where, "an instrument needs keyframes or poses");
  check_reach(tool, setup.geometry);
  setup.start = input_at(tool.script, reach_of(setup.geometry), port_of(tool, tissue), 0);
  if (tool.friction) setup.friction = *tool.friction;
  setup.power = tool.power;
  return setup;
}

/// A closed surface holds tissue off from its outside, an open one from whichever side it is on.
StillSurface still_of(const SceneSurface& still) {
  Surface surface = load_surface(still);
  const bool two_sided = !still.file.empty() && !check_manifold(surface).closed_manifold();
  return StillSurface(std::move(surface), still.friction, two_sided);
}

WorldOptions options_of(const Scene& scene) {
  WorldOptions options;
  options.gravity = scene.gravity;
  options.split = scene.cutting == CuttingMode::split;
  options.tearing = scene.tearing;
  options.heat = scene.heat;
  options.fluids = scene.fluids;
  options.contact.max_contacts = static_cast<std::size_t>(scene.max_contacts);
  options.contact.tissue_friction = scene.tissue_friction;
  options.contact.self_contact = scene.self_contact;
  return options;
}

}  // namespace

WorldSetup make_world_setup(const Scene& scene, SceneTissue tissue) {
  if (tissue.model.dynamics().mass_lumping != MassLumping::element)
    throw InputError(scene.model.string(), "has mass_lumping = \"uniform\"; a simulation needs \"element\"",
                     "leave mass_lumping and total_mass out of the model");
  std::vector<InstrumentSetup> instruments;
  for (const SceneInstrument& tool : scene.instruments) instruments.push_back(instrument_of(tool, tissue));
  std::vector<StillSurface> still;
  for (const SceneSurface& surface : scene.surfaces) still.push_back(still_of(surface));
  WorldOptions options = options_of(scene);
  options.carried = std::move(tissue.carried);
  return {std::move(tissue.model), std::move(tissue.properties), std::move(instruments),
          std::move(still),        std::move(tissue.ligaments),  std::move(options)};
}

std::string scene_hash(const Scene& scene, const WorldSetup& setup) {
  Scene plain = scene;
  plain.title.clear();
  plain.steps = 0;
  plain.patient = plain.patient.filename();
  plain.model = plain.model.filename();
  for (SceneSurface& surface : plain.surfaces) surface.file = surface.file.filename();
  for (SceneInstrument& tool : plain.instruments) tool.poses = tool.poses.filename();
  std::ostringstream text;
  write_scene(text, plain);
  text << setup.model.fingerprint();
  for (const StillSurface& still : setup.still) {
    for (const Vec3& p : still.surface().positions)
      for (int axis = 0; axis < 3; ++axis) text.write(reinterpret_cast<const char*>(&p[axis]), sizeof(double));
    for (const Triangle& triangle : still.surface().triangles)
      text.write(reinterpret_cast<const char*>(triangle.data()), sizeof triangle);
  }
  return sha256(text.str());
}

struct SceneRun::Made {
  std::vector<std::optional<Vec3>> ports;
  std::optional<Patient> patient;
  WorldSetup setup;

  static Made of(const Scene& scene) {
    SceneTissue tissue = load_tissue(scene);
    std::vector<std::optional<Vec3>> ports;
    for (const SceneInstrument& tool : scene.instruments) ports.push_back(port_of(tool, tissue));
    std::optional<Patient> patient = std::move(tissue.patient);
    tissue.patient = patient;  // its ports are asked for once more
    return {std::move(ports), std::move(patient), make_world_setup(scene, std::move(tissue))};
  }
};

SceneRun::SceneRun(const Scene& scene) : SceneRun(scene, Made::of(scene)) {}

SceneRun::SceneRun(const Scene& scene, Made made)
    : time_step_(scene.time_step),
      patient_(std::move(made.patient)),
      hash_(scene_hash(scene, made.setup)),
      world_(std::move(made.setup)) {
  for (std::size_t k = 0; k < scene.instruments.size(); ++k)
    arms_.push_back({scene.instruments[k].script, made.ports[k], reach_of(world_.instruments()[k].geometry())});
}

InstrumentInput SceneRun::asked(std::size_t instrument, double time) const {
  const Arm& arm = arms_[instrument];
  return input_at(arm.script, arm.reach, arm.port, time);
}

SceneRun::Inputs SceneRun::next_inputs() const {
  Inputs inputs;
  for (std::size_t k = 0; k < arms_.size(); ++k)
    inputs.emplace_back(asked(k, static_cast<double>(steps_ + 1) * time_step_));
  return inputs;
}

const StepReport& SceneRun::step(Inputs inputs) {
  inputs_ = std::move(inputs);
  ++steps_;
  return world_.step(inputs_);
}

}  // namespace calot
