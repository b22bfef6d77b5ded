// The world of one patient under instruments: what is set up, what a step takes, does and reports.
#pragma once
#include <array>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calot/contact/detect.h"
#include "calot/contact/friction.h"
#include "calot/sim/clip.h"
#include "calot/sim/compliance_refresh.h"
#include "calot/sim/fluids.h"
#include "calot/sim/heat.h"
#include "calot/sim/injury.h"
#include "calot/sim/instrument_arm.h"
#include "calot/sim/motion.h"
#include "calot/sim/tear.h"

namespace calot {

struct WorldOptions {
  Vec3 gravity = {0, 0, -9.81};  ///< [m/s²]
  bool split = true;             ///< scissors separate the mesh along their blades; else they remove what they cross
  bool tearing = true, heat = true, fluids = true;
  SolverOptions solver;
  FrictionOptions friction;
  ContactOptions contact;
  RefreshOptions refresh;
  double recovery = 0.5e-3;   ///< overlap that a step undoes at most [m]
  double debris = 1e-9;       ///< scraps of less than this that nothing holds are gone, as if flushed away [m³]
  double fall = 1;            ///< tissue this far below all there was at the start is lost, and stopped [m]
  double runaway_speed = 20;  ///< tissue that moves faster has run away: the step is taken back [m/s]
  /// Regions in balance as they lie at the start: what surrounds them carries their weight, which gravity doesn't move
  /// as long as their part is held by a fixed vertex or a ligament to a place. Cut off from all that, it falls.
  std::set<std::int32_t> carried;
};

struct WorldSetup {
  Model model;                                          ///< dynamic, masses lumped by element
  std::map<std::int32_t, TissueProperties> properties;  ///< of every region of the mesh
  std::vector<InstrumentSetup> instruments;
  std::vector<StillSurface> still;
  std::vector<Spring> ligaments;  ///< that hold tissue for good; those of removed tissue go
  WorldOptions options;
};

/// Where a step's time went [s].
enum class Phase : std::uint8_t { edits, compliance, waiting, free_motion, detection, contact, response, tissue };
inline constexpr std::size_t phase_count = 8;
std::string_view name_of(Phase phase);

enum class EventKind : std::uint8_t {
  cut,
  cut_refused,
  burnt,
  torn,
  clip_placed,
  clip_lost,
  grasped,
  let_go,
  slipped,
  bruised,
  leaking,
  bleeding,
  input_fault,
  input_recovered,
  not_solved,
  ran_away,
  inverted,
  overstretched,
  lost,
  debris,
};
std::string_view name_of(EventKind kind);

struct WorldEvent {
  std::uint64_t step = 0;
  EventKind kind = EventKind::cut;
  std::int32_t instrument = -1;  ///< −1: none
  double amount = 0;             ///< faces, tets, vertices, N or mL, as the text says
  std::string text;              ///< in words
};

struct StepReport {
  std::uint64_t step = 0;  ///< the first is 1
  std::array<double, phase_count> seconds{};
  SolverReport free_motion, response;
  std::size_t contacts = 0;
  FrictionSolution friction;      ///< its forces belong to `World::contacts`
  double nonlinear_residual = 0;  ///< Motion::finish
  double contact_error = 0;       ///< overlap that the step leaves beyond what it meant to, largest [m]
  double deepest_overlap = 0;     ///< of all contacts, at the step's start [m]
  std::size_t touched = 0;        ///< vertices that edits touched since the compliance was factored
  std::size_t inverted = 0;       ///< tets turned inside out
  std::size_t stuck = 0;          ///< tets beyond their ultimate stretch that no crack could relieve
  double largest_stretch = 1;
  bool ran_away = false;               ///< the step was taken back
  [[nodiscard]] double total() const;  ///< [s], without waiting
};

class World {
 public:
  /// Throws InputError for a static model, lumping other than by element, figures out of range.
  explicit World(WorldSetup setup);

  /// One step of the model's time step. Inputs: one for each instrument; empty where nothing came. Never throws for
  /// what inputs do: faults are events.
  const StepReport& step(std::span<const std::optional<InstrumentInput>> inputs);

  [[nodiscard]] const Model& model() const { return model_; }
  [[nodiscard]] const TissueState& state() const { return state_; }
  [[nodiscard]] const ContactSurface& surface() const { return surface_; }
  [[nodiscard]] const std::vector<InstrumentArm>& instruments() const { return arms_; }
  [[nodiscard]] const std::vector<Clip>& clips() const { return clips_; }
  [[nodiscard]] const TissueHeat& heat() const { return heat_; }
  [[nodiscard]] const Injury& injury() const { return injury_; }
  [[nodiscard]] const Fluids& fluids() const { return fluids_; }
  [[nodiscard]] const std::vector<TissueContact>& contacts() const { return contacts_; }  ///< of the last step
  [[nodiscard]] const FrictionProblem& friction_problem() const { return problem_; }      ///< of those contacts
  [[nodiscard]] const StepReport& report() const { return report_; }
  /// Whether a vertex is of a part that fell out of the scene: it has no weight there and meets nothing.
  [[nodiscard]] bool is_lost(VertexId v) const { return !lost_.empty() && lost_[v.index()]; }
  /// Of the last step, in order; those of edits from outside before it come first. Whoever follows the world looks at
  /// both after each step, and has then seen everything once.
  [[nodiscard]] const std::vector<WorldEvent>& events() const { return events_; }
  [[nodiscard]] const std::vector<StiffnessChange>& changes() const { return changes_; }
  [[nodiscard]] const std::map<std::int32_t, TissueProperties>& properties() const { return properties_; }
  [[nodiscard]] const WorldOptions& options() const { return options_; }
  [[nodiscard]] double time() const { return static_cast<double>(step_) * model_.dynamics().time_step; }

  /// Fills the last constraint set of one instrument, for its haptic loop.
  void haptic_constraints(std::size_t instrument, HapticConstraints& out) const;
  /// Cuts from outside, as an instrument would at the beginning of the next step, whose `events` and `changes` it
  /// begins. @return what it changed, until the next edit or step; null if it was refused or empty
  const StiffnessChange* edit(const TopologyEdit& edit, EventKind cause, const std::string& text,
                              std::int32_t instrument = -1);
  /// SHA-256 of everything that the next steps depend on.
  [[nodiscard]] std::string state_hash() const;
  /// Elastic, kinetic and gravitational energy [J].
  [[nodiscard]] double energy() const;

 private:
  class PhaseClock;
  enum class Stage : std::uint8_t { stepped, edited, stepping };
  void begin_news(Stage stage);
  void advance(std::span<const std::optional<InstrumentInput>> inputs);
  const StiffnessChange* apply(const TopologyEdit& edit, EventKind cause, const std::string& text,
                               std::int32_t instrument = -1);
  void take_inputs(std::span<const std::optional<InstrumentInput>> inputs);
  void edit_tissue();
  void cut_with_scissors(std::size_t arm);
  void remove_vaporised();
  void drop_debris();
  [[nodiscard]] std::vector<std::uint8_t> loose_groups() const;
  void part_torn();
  void stiffen();
  void gather_springs();
  void let_grasps_slide();
  void renew_compliance(PhaseClock& clock);
  [[nodiscard]] std::vector<VertexId> likely_vertices() const;
  [[nodiscard]] Preconditioner preconditioner();
  void find_contacts();
  void withdraw_blades();
  [[nodiscard]] bool is_clear(const RigidShape& shape, const Pose& pose) const;
  [[nodiscard]] double gap_of_step(const TissueContact& contact) const;
  void find_push();
  void keep_parts_apart();
  void lose_parts();
  void solve_contacts(PhaseClock& clock);
  void integrate();
  void follow_up(std::span<const Vec3> before);
  void grip_clips();
  void pull_clips(std::span<const Vec3> before);
  void update_holds();
  void update_heat();
  void update_injury();
  void update_fluids();
  void place_clip(std::size_t arm);
  [[nodiscard]] bool is_too_fast(const Vec3& motion) const;
  [[nodiscard]] bool has_run_away() const;
  void take_back();
  void relax_loose_runaways();
  void say(EventKind kind, std::int32_t instrument, double amount, std::string text);
  [[nodiscard]] TissueSurface tissue_surface() const;
  void renew_triangles();
  void weigh_carried();
  void find_carried(std::span<const Spring> springs);

  // Constant.
  std::map<std::int32_t, TissueProperties> properties_;
  std::vector<StillSurface> still_;
  WorldOptions options_;
  double deepest_ = 0;  // along gravity: parts beyond are lost [m]

  // State.
  Model model_;
  TissueState state_;
  Corotational tissue_;
  Motion motion_;
  VertexTets around_;
  std::vector<double> carried_masses_;     // n, of the carried regions; empty without any [kg]
  std::vector<std::uint32_t> tet_groups_;  // n, vertices joined by tets; empty without carried regions
  std::vector<std::uint8_t> held_groups_;  // of these, whether anything but a jaw holds them, as of the last step
  ContactSurface surface_;
  std::vector<std::array<VertexId, 3>> triangles_;
  std::vector<InstrumentArm> arms_;
  std::vector<Clip> clips_;
  std::vector<Spring> ligaments_;
  TissueHeat heat_;
  Injury injury_;
  Fluids fluids_;
  Tearing tearing_;
  ComplianceRefresh compliance_;
  std::uint64_t step_ = 0;
  std::vector<TetId> to_vaporise_;
  std::vector<TetId> to_stiffen_;
  std::vector<std::array<VertexId, 3>> to_part_;
  std::vector<std::uint8_t> closed_;  // m, tets of tubes that clips close
  std::vector<std::uint8_t> lost_;    // n, or empty while nothing is

  std::set<std::uint32_t> flowing_;  // fluid sources that flow, by id
  bool came_off_ = false;            // a part, since the compliance was last factored at once
  bool unsolved_before_ = false;
  std::size_t inverted_before_ = 0, stuck_said_ = 0;

  // Of the last step.
  Stage stage_ = Stage::stepped;
  StepReport report_;
  std::vector<WorldEvent> events_;
  std::vector<StiffnessChange> changes_;
  std::vector<Spring> springs_;
  std::size_t first_grasp_spring_ = 0;  // in springs_, those of all grasps, arm by arm
  std::vector<TissueContact> contacts_;
  std::vector<ContactRows> rows_;
  std::vector<MovingShape> shapes_;
  std::vector<std::pair<std::uint32_t, std::uint8_t>> shape_owner_;  // instrument, part (0 shaft, 1 jaw a, 2 jaw b)
  FrictionProblem problem_;
  std::map<std::uint64_t, Vec3> warm_;  // forces by contact key
  std::vector<Vec3> motion_of_step_, contact_forces_, loads_;
  std::vector<Vec3> push_;  // of the step's motion, what only undid overlaps; n, or empty
};

}  // namespace calot
