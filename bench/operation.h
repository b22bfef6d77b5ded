// The scene of the simulation's benchmarks: a gallbladder on its duct under three instruments or four.
#pragma once
#include <deque>

#include "bench/organ.h"
#include "calot/sim/world.h"

namespace calot::bench {

/// Young's moduli [Pa]: of what is beyond the duct, and of the ducts. A filled sac that is felt as soft, ducts as
/// measured (3 × 166 kPa); or everything as in the paper.
struct Stiffness {
  double body = 20e3, ducts = 500e3;
  double grip = 0.8;        ///< that the jaws may use without crushing what they hold [N]
  double squeeze = 4.5e-3;  ///< how far each tube presses in [m]
  bool tears = true;        ///< a fine mesh shows the peak of strain at the jaws, where this operation would tear it
};
inline constexpr Stiffness as_in_the_paper{1e6, 1e6, 5, 1.5e-3};

/// A group of vertices that instruments follow, through cuts too.
class Patch {
 public:
  Patch() = default;
  Patch(const TetMesh& mesh, const std::function<bool(VertexId)>& wanted);
  void follow(const std::vector<StiffnessChange>& changes);
  [[nodiscard]] bool empty() const { return ids_.empty(); }
  [[nodiscard]] const std::vector<VertexId>& vertices() const { return ids_; }
  [[nodiscard]] Vec3 centre(const TissueState& state) const;
  /// Best fit from the rest shape.
  [[nodiscard]] Mat3 rotation(const TissueState& state) const;

 private:
  std::vector<VertexId> ids_;
  std::vector<Vec3> rest_;
};

/// A grasper takes the far end of the body and lifts it by 30 mm, two blunt tubes press the body between them and rub
/// along it, and scissors, where wanted, come to the duct and close. All by plan, a function of the step and of where
/// the tissue is: the same every time. Steps of 1/60 s; gravity as for a patient who lies on the back.
class Operation {
 public:
  enum Instrument : std::size_t { grasper, first_tube, second_tube, scissors };
  /// Steps until the grasper has lifted, and until the tubes press.
  static constexpr std::size_t lifted = 130, warm_up = 180;
  /// Steps from `begin_cut` until the blades are around the duct, and until they are closed.
  static constexpr std::size_t approach = 40, closing = 36;

  Operation(const Organ& organ, const Stiffness& stiffness, bool with_scissors = false);

  const StepReport& step();
  /// The scissors come to the duct at this share of its length.
  void begin_cut(double share);
  /// What this instrument does from now on, instead of its plan.
  void drive(Instrument instrument, const InstrumentInput& input) { driven_[instrument] = input; }

  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] std::size_t steps() const { return step_; }
  [[nodiscard]] bool holds() const { return world_->instruments()[grasper].grasp->holding(); }
  /// Some vertices of the body.
  [[nodiscard]] const std::vector<VertexId>& body_vertices() const { return waist_.vertices(); }
  /// Contacts that press now (λ_n > 0).
  [[nodiscard]] std::size_t acting_contacts() const;
  /// All springs of the last step: the bed's and the jaws'.
  [[nodiscard]] std::vector<Spring> springs() const;
  /// Direction in which the second tube presses now, unit.
  [[nodiscard]] Vec3 pressing() const;

 private:
  struct Body {
    Vec3 along, across, side;  // unit: away from the duct; the thinnest way; the third
    Vec3 tip, near;            // farthest from the duct, and where the body begins
    Vec3 middle;
    Vec3 centre_of_mass = Vec3::Zero();
    double half_thickness = 0, mass = 0;
  };
  void look_at(const Organ& organ);
  [[nodiscard]] InstrumentInput grasper_input() const;
  [[nodiscard]] InstrumentInput tube_input(double side);
  [[nodiscard]] InstrumentInput scissors_input();
  [[nodiscard]] Pose around_duct() const;

  Body body_;
  std::vector<VertexId> bed_side_;
  std::vector<Spring> bed_;
  Patch waist_, duct_, duct_below_, duct_above_;
  Organ organ_;
  std::unique_ptr<World> world_;
  std::size_t step_ = 0, cut_begin_ = 0;
  bool cutting_ = false;
  Pose cut_pose_;
  Mat3 waist_turn_ = Mat3::Identity();
  Vec3 waist_place_ = Vec3::Zero();
  double duct_radius_ = 0, grip_, squeeze_;
  std::array<std::optional<InstrumentInput>, 4> driven_;
};

/// A run at real pace.
struct PacedRun {
  std::vector<double> frames;  ///< from the beginning of a step to its end, whatever it waited for [s]
  std::vector<StepReport> reports;
  [[nodiscard]] std::size_t late() const;  ///< frames longer than 1/60 s
};
/// Steps `count` times, each at its sixtieth of a second, so that background work has the time that it has in use.
/// `after_step` belongs to no frame.
PacedRun run_paced(Operation& operation, std::size_t count, const std::function<void()>& after_step = {});

}  // namespace calot::bench
