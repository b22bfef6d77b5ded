#include "bench/operation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>
#include <thread>

#include "calot/base/error.h"
#include "calot/sim/rigid_fit.h"

namespace calot::bench {
namespace {

constexpr double time_step = 1.0 / 60, pi = 3.14159265358979;
constexpr double lift = 30e-3;  // of the far end [m]
constexpr double slack = 4e-3;  // of the far end towards the near one while it is lifted [m]
constexpr double bite = 14e-3;  // how deep the jaws reach [m]
constexpr double rub = 3e-3;    // amplitude of the tubes along the body [m]
constexpr double tube_radius = 2.5e-3;
constexpr double neck_share = 0.4;        // of the body's length
constexpr double waist_reach = 7e-3;      // half the length of the part that the tubes follow [m]
constexpr double bed = 10;                // of all strands of the bed together [N/m]
constexpr double pivot_distance = 12e-3;  // from the scissors' pivot to the duct's middle [m]

double ramp(double from, double to, double at) {
  const double t = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Pose pose_of(const Vec3& x, const Vec3& z, const Vec3& position) {
  Mat3 axes;
  axes.col(2) = z.normalized();
  axes.col(0) = (x - x.dot(axes.col(2)) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return {Eigen::Quaterniond(axes), position};
}

Model softened(const Organ& organ, const Stiffness& stiffness, const std::set<std::int32_t>& body) {
  const Model& model = organ.model;
  std::map<std::int32_t, Material> materials = model.materials();
  for (auto& [region, material] : materials) material.young = body.count(region) ? stiffness.body : stiffness.ducts;
  Dynamics dynamics;
  dynamics.time_step = time_step;
  dynamics.rayleigh_mass = 5;
  dynamics.rayleigh_stiffness = 0.02;  // a loss of a quarter at 2 Hz, as soft tissue has
  return Model(model.mesh(), std::move(materials), model.fixed(), dynamics);
}

// Towards its near end the body is more and more wall, and as stiff as the duct where it meets it.
void stiffen_neck(Model& model, const Stiffness& stiffness, const std::set<std::int32_t>& body, const Vec3& near,
                  const Vec3& to_tip) {
  std::vector<TetId> neck;
  std::vector<double> factors;
  const TetMesh& mesh = model.mesh();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (!body.count(mesh.regions[t])) continue;
    Vec3 centre = Vec3::Zero();
    for (const VertexId v : mesh.tets[t]) centre += mesh.position(v) / 4;
    const double along = to_tip.dot(centre - near) / to_tip.squaredNorm() / neck_share;
    if (along >= 1) continue;
    neck.push_back(TetId(t));
    factors.push_back(std::pow(stiffness.ducts / stiffness.body, 1 - std::max(0.0, along)));
  }
  model.scale_stiffness(neck, factors);
}

// What is neither the duct nor held: the gallbladder.
std::set<std::int32_t> body_regions(const Organ& organ) {
  const TetMesh& mesh = organ.model.mesh();
  std::set<std::int32_t> others;
  for (const std::int32_t region : regions_matching(mesh, organ.duct, "duct")) others.insert(region);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (const VertexId v : mesh.tets[t])
      if (organ.model.is_fixed(v)) others.insert(mesh.regions[t]);
  std::set<std::int32_t> body;
  for (const std::int32_t region : mesh.regions)
    if (!others.count(region)) body.insert(region);
  if (body.empty()) throw InputError("the organ", "has no region beyond its duct", "use one with a gallbladder");
  return body;
}

std::vector<std::uint8_t> vertices_of(const TetMesh& mesh, const std::function<bool(std::int32_t)>& region) {
  std::vector<std::uint8_t> wanted(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (region(mesh.regions[t]))
      for (const VertexId v : mesh.tets[t]) wanted[v.index()] = 1;
  return wanted;
}

// Strands from one side of the body to what lies behind it, as the bed of a gallbladder holds it to the liver: as stiff
// as each other, and stretched so that they carry it where it lies, without turning it.
std::vector<Spring> strands(const TetMesh& mesh, const std::vector<VertexId>& attached, double weight,
                            const Vec3& centre_of_mass) {
  // The least upward forces p · (1, x, z) with the right sum and no moment.
  const auto place = [&](VertexId v) {
    const Vec3 r = (mesh.position(v) - centre_of_mass) / 0.01;
    return Vec3(1, r.x(), r.z());
  };
  Mat3 sum = Mat3::Zero();
  for (const VertexId v : attached) sum += place(v) * place(v).transpose();
  const Vec3 share = sum.ldlt().solve(Vec3(weight, 0, 0));
  const double stiffness = bed / static_cast<double>(attached.size());
  std::vector<Spring> springs;
  for (const VertexId v : attached) {
    Spring spring;
    spring.vertex = v;
    spring.anchor = mesh.position(v) + share.dot(place(v)) / stiffness * Vec3::UnitY();
    spring.stiffness = stiffness * Mat3::Identity();
    springs.push_back(spring);
  }
  return springs;
}

InstrumentSetup instrument(InstrumentKind kind, const std::string& name, const InstrumentInput& start) {
  InstrumentSetup setup;
  setup.name = name;
  setup.geometry = instrument_geometry(kind);
  setup.start = start;
  return setup;
}

}  // namespace

Patch::Patch(const TetMesh& mesh, const std::function<bool(VertexId)>& wanted) {
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (wanted(VertexId(v))) {
      ids_.push_back(VertexId(v));
      rest_.push_back(mesh.positions[v]);
    }
}

void Patch::follow(const std::vector<StiffnessChange>& changes) {
  for (const StiffnessChange& change : changes) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      const VertexId now = change.remap.vertex_to_new[ids_[k].index()];
      if (!now.valid()) continue;
      ids_[kept] = now;
      rest_[kept++] = rest_[k];
    }
    ids_.resize(kept);
    rest_.resize(kept);
  }
}

Vec3 Patch::centre(const TissueState& state) const {
  Vec3 sum = Vec3::Zero();
  for (const VertexId v : ids_) sum += state.positions[v.index()];
  return sum / static_cast<double>(ids_.size());
}

Mat3 Patch::rotation(const TissueState& state) const {
  std::vector<Vec3> now;
  for (const VertexId v : ids_) now.push_back(state.positions[v.index()]);
  return fit_rigid(rest_, now).rotation.toRotationMatrix();
}

// The body's long axis, its sides and its far end; what instruments follow.
void Operation::look_at(const Organ& organ) {
  const TetMesh& mesh = organ.model.mesh();
  const std::set<std::int32_t> regions = body_regions(organ);
  const std::vector<std::uint8_t> in_body = vertices_of(mesh, [&](std::int32_t r) { return regions.count(r) > 0; });
  Vec3 centre = Vec3::Zero();
  double count = 0;
  for (std::size_t v = 0; v < in_body.size(); ++v)
    if (in_body[v]) centre += mesh.positions[v], count += 1;
  centre /= count;
  Mat3 spread = Mat3::Zero();
  for (std::size_t v = 0; v < in_body.size(); ++v)
    if (in_body[v]) spread += (mesh.positions[v] - centre) * (mesh.positions[v] - centre).transpose();
  const Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors();
  body_.along = axes.col(2).dot(centre - organ.middle) < 0 ? Vec3(-axes.col(2)) : Vec3(axes.col(2));
  body_.across = axes.col(0);
  body_.side = body_.across.cross(body_.along);
  double farthest = -1e300, nearest = 1e300;
  for (std::size_t v = 0; v < in_body.size(); ++v)
    if (in_body[v]) {
      const double along = body_.along.dot(mesh.positions[v] - centre);
      if (along < nearest) nearest = along, body_.near = mesh.positions[v];
      if (along > farthest) farthest = along, body_.tip = mesh.positions[v];
    }
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (!regions.count(mesh.regions[t])) continue;
    const double mass =
        organ.model.material(TetId(t)).density *
        signed_volume(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
    body_.mass += mass;
    for (const VertexId v : tet) body_.centre_of_mass += mass / 4 * mesh.position(v);
  }
  body_.centre_of_mass /= body_.mass;
  double behind = 0;
  for (std::size_t v = 0; v < in_body.size(); ++v)
    if (in_body[v]) behind = std::min(behind, body_.side.dot(mesh.positions[v] - centre));
  bed_side_.clear();
  for (std::size_t v = 0; v < in_body.size(); ++v)
    if (in_body[v] && body_.side.dot(mesh.positions[v] - centre) < 0.6 * behind) bed_side_.push_back(VertexId(v));
  const double waist = 0.5 * (nearest + farthest);
  waist_ = Patch(mesh, [&](VertexId v) {
    return in_body[v.index()] && std::abs(body_.along.dot(mesh.position(v) - centre) - waist) < waist_reach;
  });
  body_.middle = waist_.centre({mesh.positions, {}});
  for (const VertexId v : waist_.vertices()) {
    const Vec3 x = mesh.position(v) - body_.middle;
    if (std::abs(body_.side.dot(x)) < 6e-3)
      body_.half_thickness = std::max(body_.half_thickness, std::abs(body_.across.dot(x)));
  }
}

Operation::Operation(const Organ& organ, const Stiffness& stiffness, bool with_scissors)
    : organ_(organ), grip_(stiffness.grip), squeeze_(stiffness.squeeze) {
  look_at(organ);
  Model model = softened(organ, stiffness, body_regions(organ));
  stiffen_neck(model, stiffness, body_regions(organ), body_.near, body_.tip - body_.near);
  std::map<std::int32_t, TissueProperties> properties = tissue_properties(model.mesh());
  WorldSetup setup{std::move(model), std::move(properties), {}, {}, {}, {}};
  setup.options.gravity = Vec3(0, -9.81, 0);
  setup.options.tearing = stiffness.tears;
  setup.ligaments = bed_ = strands(setup.model.mesh(), bed_side_, 9.81 * body_.mass, body_.centre_of_mass);
  const InstrumentGeometry jaws = instrument_geometry(InstrumentKind::bowel_grasper);
  InstrumentInput start;
  start.pose =
      pose_of(body_.across.cross(-body_.along), -body_.along, body_.tip + (jaws.jaw_length - bite) * body_.along);
  start.opening = jaws.max_opening;
  setup.instruments.push_back(instrument(InstrumentKind::bowel_grasper, "grasper", start));
  for (const double side : {-1.0, 1.0}) {
    InstrumentInput away;
    away.pose = pose_of(body_.across, body_.side,
                        body_.middle + side * (body_.half_thickness + 25e-3) * body_.across + 12e-3 * body_.side);
    setup.instruments.push_back(instrument(InstrumentKind::suction, side < 0 ? "first tube" : "second tube", away));
  }
  if (with_scissors) {
    InstrumentInput open;
    const Vec3 off = (organ.middle - body_.middle).normalized();
    open.pose = pose_of(off.unitOrthogonal(), -off, organ.middle + 60e-3 * off);
    open.opening = 0;
    setup.instruments.push_back(instrument(InstrumentKind::scissors, "scissors", open));
  }
  world_ = std::make_unique<World>(std::move(setup));
}

// On an arc around the body's near end, so that it is turned up and not stretched; then a little to and fro.
InstrumentInput Operation::grasper_input() const {
  const auto k = static_cast<double>(step_);
  InstrumentInput input = world_->instruments()[grasper].setup().start;
  Vec3 up(0, 1, 0);
  up -= up.dot(body_.along) * body_.along;
  up = up.norm() > 0.1 ? Vec3(up.normalized()) : body_.across;
  const double swing = k > warm_up ? 2e-3 * std::sin(2 * pi * 0.4 * time_step * (k - warm_up)) : 0;
  const double angle = (lift * ramp(30, lifted, k) + swing) / (body_.tip - body_.near).norm();
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, body_.along.cross(up)));
  input.pose = Pose{turn, body_.near - turn * body_.near} * input.pose;
  input.pose.position -= slack * ramp(30, 80, k) * (turn * body_.along);
  input.opening *= 1 - std::min(1.0, k / 30);
  input.grip = grip_ * ramp(0, 6, k);
  return input;
}

// Across the body, a little beyond it, pressing from one side. The hand follows the body until it is lifted, and then
// stays: following on would drag it along.
InstrumentInput Operation::tube_input(double side) {
  const auto k = static_cast<double>(step_);
  if (step_ <= lifted) {
    waist_turn_ = waist_.rotation(world_->state());
    waist_place_ = waist_.centre(world_->state());
  }
  const double away = 25e-3 * (1 - ramp(20, lifted, k)), pressed = squeeze_ * ramp(lifted, warm_up, k);
  const double slide = k > warm_up ? rub * std::sin(2 * pi * 0.5 * time_step * (k - warm_up)) : 0;
  const Vec3 across = waist_turn_ * body_.across;
  InstrumentInput input;
  input.pose = pose_of(across, waist_turn_ * body_.side,
                       waist_place_ + side * (body_.half_thickness + tube_radius + away - pressed) * across +
                           waist_turn_ * (12e-3 * body_.side + side * slide * body_.along));
  return input;
}

void Operation::begin_cut(double share) {
  const TetMesh& mesh = world_->model().mesh();
  const std::vector<std::int32_t> regions = regions_matching(mesh, organ_.duct, "duct");
  const std::vector<std::uint8_t> in_duct =
      vertices_of(mesh, [&](std::int32_t r) { return std::find(regions.begin(), regions.end(), r) != regions.end(); });
  const double at = (share - 0.5) * organ_.length;
  const auto between = [&](double low, double high) {
    return Patch(mesh, [&, low, high](VertexId v) {
      const double along = organ_.axis.dot(mesh.position(v) - organ_.middle) - at;
      return in_duct[v.index()] && along > low && along < high;
    });
  };
  duct_ = between(-3e-3, 3e-3);
  duct_below_ = between(-8e-3, 0);
  duct_above_ = between(0, 8e-3);
  if (duct_.empty() || duct_below_.empty() || duct_above_.empty())
    throw InputError("the organ", "has no duct where it is to be cut", "use a finer mesh");
  const Vec3 middle = duct_.centre({mesh.positions, {}});
  const Vec3 tangent =
      (duct_above_.centre({mesh.positions, {}}) - duct_below_.centre({mesh.positions, {}})).normalized();
  for (const VertexId v : duct_.vertices())
    duct_radius_ = std::max(duct_radius_, (mesh.position(v) - middle).cross(tangent).norm());
  duct_radius_ = std::min(duct_radius_, 4e-3);
  cut_begin_ = step_;
  cutting_ = true;
}

// Blades across the duct as it lies now, the pivot on the side that looks away from the body.
Pose Operation::around_duct() const {
  const TissueState& state = world_->state();
  const Vec3 middle = duct_.centre(state);
  const Vec3 tangent = (duct_above_.centre(state) - duct_below_.centre(state)).normalized();
  Vec3 off = middle - waist_.centre(state);
  off -= off.dot(tangent) * tangent;
  off = off.norm() > 1e-3 ? Vec3(off.normalized()) : tangent.unitOrthogonal();
  return pose_of(tangent, -off, middle + pivot_distance * off);
}

InstrumentInput Operation::scissors_input() {
  const InstrumentGeometry& geometry = world_->instruments()[scissors].geometry();
  InstrumentInput input = world_->instruments()[scissors].setup().start;
  if (!cutting_) return input;
  const auto k = static_cast<double>(step_ - cut_begin_);
  // The duct gives way as long as it is whole.
  if (step_ - cut_begin_ <= approach + 12 && !world_->instruments()[scissors].in_cut) cut_pose_ = around_duct();
  const Pose far = input.pose;
  const double near = ramp(0, approach, k);
  input.pose = {far.rotation.slerp(near, cut_pose_.rotation),
                far.position + near * (cut_pose_.position - far.position)};
  input.opening = geometry.max_opening * ramp(0, 10, k);
  if (step_ - cut_begin_ <= approach) return input;
  // The edges cross in front of the duct after five steps, then pass it evenly, then close.
  const double closes = k - approach, reach = duct_radius_ + 1.5e-3;
  const double first = pivot_distance - reach, last = std::min(pivot_distance + reach, 0.95 * geometry.jaw_length);
  const double crossing = first + (last - first) * std::clamp((closes - 5) / (closing - 6.0), 0.0, 1.0);
  const double angle = 2 * std::asin(geometry.blade_offset / crossing);
  input.opening =
      std::min(geometry.max_opening, angle + (geometry.max_opening - angle) * std::max(0.0, 1 - closes / 5));
  if (closes >= closing) input.opening = 0;
  return input;
}

const StepReport& Operation::step() {
  std::vector<std::optional<InstrumentInput>> inputs{grasper_input(), tube_input(-1), tube_input(1)};
  if (world_->instruments().size() > scissors) inputs.emplace_back(scissors_input());
  for (std::size_t k = 0; k < inputs.size(); ++k)
    if (driven_[k]) inputs[k] = driven_[k];
  ++step_;
  const StepReport& report = world_->step(inputs);
  for (Patch* patch : {&waist_, &duct_, &duct_below_, &duct_above_}) patch->follow(world_->changes());
  for (const StiffnessChange& change : world_->changes()) {
    for (Spring& strand : bed_) strand.vertex = change.remap.vertex_to_new[strand.vertex.index()];
    std::erase_if(bed_, [](const Spring& strand) { return !strand.vertex.valid(); });
  }
  return report;
}

std::size_t Operation::acting_contacts() const {
  std::size_t count = 0;
  for (std::size_t k = 0; k < world_->contacts().size(); ++k)
    if (world_->report().friction.forces[3 * static_cast<Eigen::Index>(k)] > 0) ++count;
  return count;
}

std::vector<Spring> Operation::springs() const {
  std::vector<Spring> springs = bed_;
  world_->instruments()[grasper].grasp->springs(springs);
  return springs;
}

Vec3 Operation::pressing() const {
  return -(waist_.rotation(world_->state()) * body_.across);
}

std::size_t PacedRun::late() const {
  return static_cast<std::size_t>(std::count_if(frames.begin(), frames.end(), [](double s) { return s > time_step; }));
}

PacedRun run_paced(Operation& operation, std::size_t count, const std::function<void()>& after_step) {
  PacedRun run;
  const std::chrono::duration<double> frame(time_step);
  auto next = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < count; ++k) {
    const Stopwatch watch;
    const StepReport& report = operation.step();
    run.frames.push_back(watch.seconds());
    run.reports.push_back(report);
    if (after_step) after_step();
    next += std::chrono::duration_cast<std::chrono::steady_clock::duration>(frame);
    // A late frame shifts those that follow: nothing is caught up on.
    next = std::max(next, std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
  return run;
}

}  // namespace calot::bench
