#include "calot/sim/world.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/mesh/parts.h"
#include "calot/sim/instrument_state.h"
#include "calot/sim/rigid_fit.h"
#include "calot/sim/world_clock.h"

namespace calot {
namespace {

const Model& checked(const Model& model) {
  if (model.dynamics().is_static())
    throw InputError("time_step", "is 0: a simulation needs steps", "give a step such as 0.0166667 s");
  if (model.dynamics().mass_lumping != MassLumping::element)
    throw InputError("mass_lumping", "must be \"element\" in a simulation", "leave it out of the model");
  return model;
}

const std::vector<Spring>& checked(const std::vector<Spring>& ligaments, const TetMesh& mesh) {
  for (std::size_t k = 0; k < ligaments.size(); ++k) {
    const Spring& spring = ligaments[k];
    const auto refuse = [&](const std::string& what, const std::string& remedy) {
      throw InputError("ligament " + std::to_string(k), what, remedy);
    };
    for (const VertexId v : {spring.vertex, spring.other})
      if (v.index() >= mesh.vertex_count() && (v.valid() || v == spring.vertex))
        refuse("names a vertex that the mesh doesn't have", "name one below " + std::to_string(mesh.vertex_count()));
    if (!spring.anchor.allFinite() || !spring.velocity.allFinite())
      refuse("has an anchor that isn't finite", "give a place in metres");
    const double size = spring.stiffness.norm();
    if (!std::isfinite(size) || !((spring.stiffness - spring.stiffness.transpose()).norm() <= 1e-9 * size) ||
        !(Eigen::SelfAdjointEigenSolver<Mat3>(spring.stiffness, Eigen::EigenvaluesOnly).eigenvalues().minCoeff() >=
          -1e-9 * size))
      refuse("has a stiffness that isn't symmetric and positive semidefinite", "give one in N/m that is");
    if (!(spring.damping >= 0) || !std::isfinite(spring.damping)) refuse("has a damping below 0", "give one >= 0 s");
  }
  return ligaments;
}

Vec3 down(const Vec3& gravity) {
  const double size = gravity.norm();
  return size > 0 ? Vec3(gravity / size) : Vec3(Vec3::Zero());
}

// How deep the lowest of everything lies, along gravity; without gravity nothing is ever deeper.
double depth_of(const TetMesh& mesh, const std::vector<StillSurface>& still, const Vec3& gravity) {
  if (gravity.isZero(0)) return std::numeric_limits<double>::infinity();
  double deepest = -std::numeric_limits<double>::infinity();
  const auto look = [&](const std::vector<Vec3>& positions) {
    for (const Vec3& x : positions) deepest = std::max(deepest, x.dot(down(gravity)));
  };
  look(mesh.positions);
  for (const StillSurface& surface : still) look(surface.surface().positions);
  return deepest;
}

std::vector<VertexId> supplies_of(const WorldSetup& setup) {
  return supply_vertices(setup.model.mesh(), setup.properties, setup.model.fixed());
}

}  // namespace

std::string_view name_of(Phase phase) {
  switch (phase) {
    case Phase::edits:
      return "edits";
    case Phase::compliance:
      return "compliance";
    case Phase::waiting:
      return "waiting";
    case Phase::free_motion:
      return "free motion";
    case Phase::detection:
      return "detection";
    case Phase::contact:
      return "contact";
    case Phase::response:
      return "response";
    case Phase::tissue:
      return "tissue";
  }
  return "";
}

std::string_view name_of(EventKind kind) {
  switch (kind) {
    case EventKind::cut:
      return "cut";
    case EventKind::cut_refused:
      return "cut refused";
    case EventKind::burnt:
      return "burnt";
    case EventKind::torn:
      return "torn";
    case EventKind::clip_placed:
      return "clip placed";
    case EventKind::clip_lost:
      return "clip lost";
    case EventKind::grasped:
      return "grasped";
    case EventKind::let_go:
      return "let go";
    case EventKind::slipped:
      return "slipped";
    case EventKind::bruised:
      return "bruised";
    case EventKind::leaking:
      return "leaking";
    case EventKind::bleeding:
      return "bleeding";
    case EventKind::input_fault:
      return "input fault";
    case EventKind::not_solved:
      return "not solved";
    case EventKind::input_recovered:
      return "input recovered";
    case EventKind::ran_away:
      return "ran away";
    case EventKind::inverted:
      return "inverted";
    case EventKind::overstretched:
      return "overstretched";
    case EventKind::lost:
      return "lost";
    case EventKind::debris:
      return "debris";
  }
  return "";
}

double StepReport::total() const {
  double sum = 0;
  for (std::size_t k = 0; k < phase_count; ++k)
    if (static_cast<Phase>(k) != Phase::waiting) sum += seconds[k];
  return sum;
}

World::World(WorldSetup setup)
    : properties_(setup.properties),
      still_(std::move(setup.still)),
      options_(setup.options),
      model_(checked(setup.model)),
      state_{model_.mesh().positions, std::vector<Vec3>(model_.mesh().vertex_count(), Vec3::Zero())},
      tissue_(model_),
      motion_(model_),
      around_(vertex_tets(model_.mesh())),
      surface_(model_.mesh()),
      ligaments_(checked(setup.ligaments, model_.mesh())),
      heat_(model_.mesh(), properties_),
      injury_(model_.mesh(), properties_),
      fluids_(model_.mesh(), properties_, supplies_of(setup)),
      tearing_(model_.mesh(), properties_),
      compliance_(model_, tissue_, ligaments_, options_.refresh) {
  for (InstrumentSetup& instrument : setup.instruments) arms_.emplace_back(std::move(instrument));
  deepest_ = depth_of(model_.mesh(), still_, options_.gravity) + options_.fall;
  closed_.assign(model_.mesh().tet_count(), 0);
  renew_triangles();
  weigh_carried();
}

void World::weigh_carried() {
  if (options_.carried.empty()) return;
  const TetMesh& mesh = model_.mesh();
  carried_masses_.assign(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (!options_.carried.contains(mesh.regions[t])) continue;
    const double mass = model_.material(TetId(t)).density * signed_volume(mesh, TetId(t));
    for (const VertexId v : mesh.tets[t]) carried_masses_[v.index()] += mass / 4;
  }
  tet_groups_ = vertex_connected_groups(mesh);
  find_carried(ligaments_);
}

// Which groups are held: by a fixed vertex or a ligament to a place, or through springs between tissue by another that
// is. Jaws carry what they hold with its weight.
void World::find_carried(std::span<const Spring> springs) {
  if (tet_groups_.empty()) return;
  std::vector<std::uint32_t> root(1 + *std::max_element(tet_groups_.begin(), tet_groups_.end()));
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](VertexId v) {
    std::uint32_t g = tet_groups_[v.index()];
    while (root[g] != g) g = root[g] = root[root[g]];
    return g;
  };
  for (const Spring& spring : springs) {
    if (!spring.other.valid()) continue;
    const std::uint32_t a = find(spring.vertex), b = find(spring.other);
    root[std::max(a, b)] = std::min(a, b);
  }
  held_groups_.assign(root.size(), 0);
  for (std::size_t v = 0; v < tet_groups_.size(); ++v)
    if (model_.is_fixed(VertexId(v))) held_groups_[find(VertexId(v))] = 1;
  for (const Spring& ligament : ligaments_)
    if (!ligament.other.valid()) held_groups_[find(ligament.vertex)] = 1;
  for (std::uint32_t g = 0; g < root.size(); ++g) held_groups_[g] = held_groups_[root[g]];  // roots come first
}

void World::renew_triangles() {
  triangles_.resize(surface_.triangles().size());
  for (std::size_t k = 0; k < triangles_.size(); ++k) triangles_[k] = surface_.triangles()[k].vertices;
}

TissueSurface World::tissue_surface() const {
  return {triangles_, state_.positions};
}

void World::say(EventKind kind, std::int32_t instrument, double amount, std::string text) {
  events_.push_back({stage_ == Stage::stepping ? step_ : step_ + 1, kind, instrument, amount, std::move(text)});
}

// Events and changes of a step are gathered from the first edit before it on.
void World::begin_news(Stage stage) {
  if (stage_ == Stage::stepped) {
    events_.clear();
    changes_.clear();
  }
  stage_ = stage;
}

const StepReport& World::step(std::span<const std::optional<InstrumentInput>> inputs) {
  begin_news(Stage::stepping);
  ++step_;
  report_ = {};
  report_.step = step_;
  advance(inputs);
  stage_ = Stage::stepped;
  return report_;
}

void World::advance(std::span<const std::optional<InstrumentInput>> inputs) {
  PhaseClock clock(report_.seconds);
  take_inputs(inputs);
  if (model_.mesh().tet_count() == 0) return;
  edit_tissue();
  if (model_.mesh().tet_count() == 0) return;
  clock.end(Phase::edits);
  renew_compliance(clock);
  motion_.begin(tissue_, state_, options_.gravity, springs_, loads_);
  motion_of_step_.resize(state_.positions.size());
  report_.free_motion = motion_.solve_free(preconditioner(), options_.solver, motion_of_step_);
  let_grasps_slide();
  clock.end(Phase::free_motion);
  if (has_run_away()) {
    take_back();
    return;
  }
  find_contacts();
  clock.end(Phase::detection);
  solve_contacts(clock);
  if (has_run_away()) {
    take_back();
    clock.end(Phase::tissue);
    return;
  }
  const std::vector<Vec3> before = state_.positions;
  integrate();
  lose_parts();
  follow_up(before);
  clock.end(Phase::tissue);
}

Preconditioner World::preconditioner() {
  WarpedCompliance& present = compliance_.present();
  const auto apply = [&present](std::span<const Vec3> r, std::span<Vec3> z) {
    present.apply(r, z, WarpedCompliance::Use::preconditioner);
  };
  return {apply, present.mixes_parts()};
}

void World::take_inputs(std::span<const std::optional<InstrumentInput>> inputs) {
  for (std::size_t k = 0; k < arms_.size(); ++k) {
    InstrumentArm& arm = arms_[k];
    arm.take(k < inputs.size() ? inputs[k] : std::nullopt, model_.dynamics().time_step);
    if (arm.status() == arm.status_before()) continue;
    const auto number = static_cast<std::int32_t>(k);
    if (arm.status() == InputStatus::good)
      say(EventKind::input_recovered, number, 0, std::string(words_of(arm.status())));
    else if (arm.status() != InputStatus::recovering)
      say(EventKind::input_fault, number, 0, std::string(words_of(arm.status())));
  }
}

// Vertices that blades and hooks may touch soon, nearest first: their columns of the compliance are made ready with the
// next factor. Blades touch what lies about their plane, between their edges.
std::vector<VertexId> World::likely_vertices() const {
  constexpr double reach = 5e-3;
  constexpr std::size_t most = 64;
  std::vector<std::pair<double, VertexId>> near;
  for (const InstrumentArm& arm : arms_) {
    const InstrumentGeometry& g = arm.geometry();
    const bool cuts = arm.scissors && arm.opening_to() > 0.02;
    const bool burns = g.kind == InstrumentKind::hook && arm.input().energy;
    if (!cuts && !burns) continue;
    const Pose inverse = arm.to().inverse();
    for (std::size_t v = 0; v < state_.positions.size(); ++v) {
      if (model_.is_fixed(VertexId(v))) continue;
      const Vec3 x = inverse * state_.positions[v];
      if (burns) {
        if (const double distance = (x - g.hook_tip).norm(); distance < reach) near.emplace_back(distance, VertexId(v));
      } else if (std::abs(x.x()) < reach && x.z() > -reach && x.z() < g.jaw_length + reach &&
                 std::abs(x.y()) < x.z() * std::tan(arm.opening_to() / 2) + reach) {
        near.emplace_back(std::abs(x.x()), VertexId(v));
      }
    }
  }
  std::sort(near.begin(), near.end());
  std::vector<VertexId> likely;
  for (const auto& [distance, v] : near) {
    if (likely.size() == most) break;
    if (std::find(likely.begin(), likely.end(), v) == likely.end()) likely.push_back(v);
  }
  return likely;
}

void World::gather_springs() {
  const double h = model_.dynamics().time_step;
  springs_ = ligaments_;
  const TissueSurface surface = tissue_surface();
  for (InstrumentArm& arm : arms_) {
    if (!arm.grasp || arm.held_clip >= 0) continue;
    arm.grasp->update({h, arm.from(), arm.to(), arm.input().opening, arm.input().grip, surface, state_.velocities,
                       model_.mesh().positions});
    arm.set_opening(arm.grasp->opening());
  }
  grip_clips();
  first_grasp_spring_ = springs_.size();
  for (const InstrumentArm& arm : arms_)
    if (arm.grasp) arm.grasp->springs(springs_);
  loads_.assign(state_.positions.size(), Vec3::Zero());
  for (std::size_t v = 0; v < lost_.size(); ++v)
    if (lost_[v]) loads_[v] = -motion_.masses()[v] * options_.gravity;
  for (Clip& clip : clips_) {
    clip.springs(h, springs_);
    clip.loads(loads_);
  }
  find_carried(springs_);
  for (std::size_t v = 0; v < carried_masses_.size(); ++v)
    if (held_groups_[tet_groups_[v]]) loads_[v] -= carried_masses_[v] * options_.gravity;
}

// Springs of jaws were softened beforehand for tissue that goes on as it went. A pull that grew within the step passes
// friction's limit there: where by more than a little, those places slide in a second solve.
void World::let_grasps_slide() {
  constexpr double little = 0.05;
  const auto holds = [](const InstrumentArm& arm) { return arm.grasp && arm.grasp->holding(); };
  if (std::none_of(arms_.begin(), arms_.end(), holds)) return;
  std::vector<Vec3> trial = state_.positions;
  for (std::size_t v = 0; v < trial.size(); ++v) trial[v] += motion_of_step_[v];
  bool slides = false;
  std::vector<Spring> again;
  for (InstrumentArm& arm : arms_) {
    if (holds(arm) && arm.grasp->excess(trial) > little && arm.grasp->correct(trial)) slides = true;
    if (arm.grasp) arm.grasp->springs(again);
  }
  if (!slides) return;
  std::copy(again.begin(), again.end(), springs_.begin() + static_cast<std::ptrdiff_t>(first_grasp_spring_));
  compliance_.set_springs(springs_);
  compliance_.present().settle();
  compliance_.present().turn(vertex_rotations(around_, tissue_.rotations()));
  motion_.begin(tissue_, state_, options_.gravity, springs_, loads_);
  const int before = report_.free_motion.iterations;
  report_.free_motion = motion_.solve_free(preconditioner(), options_.solver, motion_of_step_);
  report_.free_motion.iterations += before;
}

void World::renew_compliance(PhaseClock& clock) {
  gather_springs();
  report_.seconds[static_cast<std::size_t>(Phase::waiting)] = compliance_.adopt(step_);
  compliance_.set_springs(springs_);
  constexpr std::size_t most_pending = 150, most_touched = 400;
  if (compliance_.present().pending() > most_pending ||
      compliance_.present().pending() + compliance_.present().touched() > most_touched)
    compliance_.rebuild(model_, tissue_, springs_);
  compliance_.present().settle();
  // A part has just come off. To go on in double precision and part by part, until the next factor is there, costs more
  // than a factor now.
  if (came_off_ && compliance_.present().mixes_parts() && compliance_.present().needs_double()) {
    compliance_.rebuild(model_, tissue_, springs_);
    compliance_.present().settle();
    came_off_ = false;
  }
  if (compliance_.start_is_due(step_)) compliance_.start(step_, model_, tissue_, springs_, likely_vertices());
  WarpedCompliance& present = compliance_.present();
  present.turn(vertex_rotations(around_, tissue_.rotations()));
  report_.touched = present.touched();
  clock.end(Phase::compliance, report_.seconds[static_cast<std::size_t>(Phase::waiting)]);
}

void World::integrate() {
  const double h = model_.dynamics().time_step;
  const TissueState before = state_;
  for (std::size_t v = 0; v < state_.positions.size(); ++v) {
    state_.positions[v] += motion_of_step_[v];
    state_.velocities[v] = motion_of_step_[v] / h;
  }
  const bool solved = report_.free_motion.converged && report_.response.converged && report_.friction.converged;
  if (!solved && !unsolved_before_)
    say(EventKind::not_solved, -1, report_.free_motion.residual,
        std::string(!report_.free_motion.converged ? "the motion"
                    : !report_.response.converged  ? "the answer to contacts"
                                                   : "friction") +
            " was not solved to its tolerance");
  unsolved_before_ = !solved;
  tissue_.update_rotations(state_.positions);
  report_.nonlinear_residual = motion_.finish(before, state_, contact_forces_);
  for (std::size_t v = 0; v < push_.size(); ++v) state_.velocities[v] -= push_[v] / h;
}

// Parts that fell out of the scene: stopped, and without weight from now on. Parts that anything holds stay.
void World::lose_parts() {
  const Vec3 along = down(options_.gravity);
  const auto fallen = [&](std::size_t v) { return state_.positions[v].dot(along) > deepest_; };
  bool any = false;
  for (std::size_t v = 0; v < state_.positions.size() && !any; ++v) any = !is_lost(VertexId(v)) && fallen(v);
  if (!any) return;
  const std::span<const std::uint32_t> parts = motion_.parts();
  std::vector<std::uint8_t> falls(motion_.part_count(), 1);
  for (std::size_t v = 0; v < parts.size(); ++v)
    if (!fallen(v) || model_.is_fixed(VertexId(v)) || is_lost(VertexId(v))) falls[parts[v]] = 0;
  for (const Spring& spring : springs_)
    if (!spring.other.valid()) falls[parts[spring.vertex.index()]] = 0;
  if (std::count(falls.begin(), falls.end(), 1) == 0) return;
  lost_.resize(parts.size(), 0);
  for (std::size_t v = 0; v < parts.size(); ++v) {
    if (!falls[parts[v]]) continue;
    lost_[v] = 1;
    state_.velocities[v].setZero();
  }
  std::vector<std::size_t> tets(falls.size(), 0);
  for (const Tet& tet : model_.mesh().tets) ++tets[parts[tet[0].index()]];
  for (std::size_t part = 0; part < falls.size(); ++part)
    if (falls[part])
      say(EventKind::lost, -1, static_cast<double>(tets[part]),
          "a part of " + std::to_string(tets[part]) + " tets fell out of the scene, and is left where it is");
}

bool World::is_too_fast(const Vec3& motion) const {  // what isn't a number is
  return !(motion.norm() <= options_.runaway_speed * model_.dynamics().time_step);
}

bool World::has_run_away() const {
  return !std::isfinite(report_.free_motion.residual) || !std::isfinite(report_.response.residual) ||
         std::any_of(motion_of_step_.begin(), motion_of_step_.end(), [&](const Vec3& d) { return is_too_fast(d); });
}

// The last good state stays, at rest; the next step begins from there.
void World::take_back() {
  relax_loose_runaways();
  for (Vec3& v : state_.velocities) v.setZero();
  contacts_.clear();
  contact_forces_.clear();
  push_.clear();
  rows_.clear();
  problem_ = {};
  warm_.clear();
  for (InstrumentArm& arm : arms_) arm.force.setZero();
  motion_.follow(model_);
  report_.ran_away = true;
  say(EventKind::ran_away, -1, 0, "tissue moved faster than it can; the last good state is kept, at rest");
}

// Loose tissue that ran away would do so again from where it is: it gets its rest shape back there.
void World::relax_loose_runaways() {
  const std::span<const std::uint32_t> group = motion_.groups();
  const std::vector<std::uint8_t> loose = loose_groups();
  std::vector<std::uint8_t> ran(loose.size(), 0);
  for (std::size_t v = 0; v < group.size(); ++v)
    if (loose[group[v]] && is_too_fast(motion_of_step_[v])) ran[group[v]] = 1;
  for (std::uint32_t g = 0; g < ran.size(); ++g) {
    if (!ran[g]) continue;
    std::vector<std::size_t> members;
    std::vector<Vec3> rest, now;
    for (std::size_t v = 0; v < group.size(); ++v) {
      if (group[v] != g) continue;
      members.push_back(v);
      rest.push_back(model_.mesh().positions[v]);
      now.push_back(state_.positions[v]);
    }
    const Pose here = fit_rigid(rest, now);
    for (std::size_t k = 0; k < members.size(); ++k) state_.positions[members[k]] = here * rest[k];
  }
  tissue_.update_rotations(state_.positions);
}

double World::energy() const {
  double sum = tissue_.energy(state_.positions);
  for (std::size_t v = 0; v < state_.positions.size(); ++v)
    sum += motion_.masses()[v] * (0.5 * state_.velocities[v].squaredNorm() - options_.gravity.dot(state_.positions[v]));
  for (std::size_t v = 0; v < carried_masses_.size(); ++v)
    if (held_groups_[tet_groups_[v]]) sum += carried_masses_[v] * options_.gravity.dot(state_.positions[v]);
  return sum;
}

std::string World::state_hash() const {
  std::string bytes;
  const auto add = [&](const auto& values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  for (const std::vector<Vec3>* list : {&state_.positions, &state_.velocities, &model_.mesh().positions})
    for (const Vec3& v : *list) detail::append_bytes(bytes, v);
  detail::append_bytes(bytes, step_);
  for (const auto& [key, force] : warm_) {
    detail::append_bytes(bytes, key);
    detail::append_bytes(bytes, force);
  }
  for (const Spring& spring : ligaments_) {
    detail::append_bytes(bytes, spring.vertex.value);
    detail::append_bytes(bytes, spring.anchor);
    for (int k = 0; k < 3; ++k) detail::append_bytes(bytes, Vec3(spring.stiffness.col(k)));
  }
  for (const std::vector<TetId>* list : {&to_vaporise_, &to_stiffen_})
    for (const TetId t : *list) detail::append_bytes(bytes, t.value);
  for (const auto& face : to_part_)
    for (const VertexId v : face) detail::append_bytes(bytes, v.value);
  add(closed_);
  add(lost_);
  add(model_.fixed());
  add(model_.mesh().tets);
  add(model_.mesh().regions);
  add(model_.stiffness_scale());
  for (const Eigen::Quaterniond& q : tissue_.rotations())
    for (int k = 0; k < 4; ++k) detail::append_bytes(bytes, q.coeffs()[k]);
  for (const InstrumentArm& arm : arms_) arm.append_state(bytes);
  for (const Clip& clip : clips_) clip.append_state(bytes);
  heat_.append_state(bytes);
  injury_.append_state(bytes);
  fluids_.append_state(bytes);
  tearing_.append_state(bytes);
  return sha256(bytes);
}

}  // namespace calot
