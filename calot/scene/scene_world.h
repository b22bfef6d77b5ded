// From a scene to a world that runs.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calot/scene/scene.h"
#include "calot/scene/tissue.h"
#include "calot/sim/world.h"

namespace calot {

/// Everything that a world needs, instruments where their scripts begin. Throws InputError naming the scene's line: for
/// what its files and ports are, and for openings and grips beyond an instrument's.
WorldSetup make_world_setup(const Scene& scene, SceneTissue tissue);

/// SHA-256 of all that decides what a run does, apart from its inputs: the scene's figures, the model, still surfaces.
/// Not its title, its length, its comments or where its files lie.
std::string scene_hash(const Scene& scene, const WorldSetup& setup);

/// A world, and instruments that follow the scene's scripts.
class SceneRun {
 public:
  using Inputs = std::vector<std::optional<InstrumentInput>>;
  /// Reads the files that the scene names. Throws InputError.
  explicit SceneRun(const Scene& scene);

  /// What an instrument's script asks at a time [s].
  [[nodiscard]] InstrumentInput asked(std::size_t instrument, double time) const;
  /// Where an instrument's port is, if it has one [m].
  [[nodiscard]] const std::optional<Vec3>& port(std::size_t instrument) const { return arms_[instrument].port; }
  /// What the scripts ask of each instrument at the end of the next step.
  [[nodiscard]] Inputs next_inputs() const;
  /// One step by the scripts.
  const StepReport& step() { return step(next_inputs()); }
  /// One step by other inputs: from a device or a recording.
  const StepReport& step(Inputs inputs);

  /// Changed by inputs alone, so that these are all that a recording needs. Edits from outside: make a World of
  /// `make_world_setup`.
  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const Inputs& inputs() const { return inputs_; }   ///< of the last step
  [[nodiscard]] std::uint64_t steps() const { return steps_; }     ///< done
  [[nodiscard]] const std::string& hash() const { return hash_; }  ///< `scene_hash`
  [[nodiscard]] const std::optional<Patient>& patient() const { return patient_; }

 private:
  struct Arm {
    InstrumentScript script;
    std::optional<Vec3> port;
    double reach = 0;  // [m]
  };
  struct Made;
  SceneRun(const Scene& scene, Made made);

  std::vector<Arm> arms_;
  double time_step_;
  std::optional<Patient> patient_;
  std::string hash_;
  World world_;
  Inputs inputs_;
  std::uint64_t steps_ = 0;
};

}  // namespace calot
