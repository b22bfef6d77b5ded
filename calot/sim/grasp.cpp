#include "calot/sim/grasp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calot/base/error.h"
#include "calot/sim/instrument_state.h"

namespace calot {
namespace {

Pose jaw_pose(const InstrumentGeometry& geometry, const Pose& instrument, double opening, JawSide side) {
  const ArticulatedPoses poses = articulate(geometry, opening);
  return instrument * (side == JawSide::a ? poses.jaw_a : poses.jaw_b);
}

/// From a jaw's face into the mouth, in the jaw's frame.
Vec3 face_direction(JawSide side) {
  return side == JawSide::a ? Vec3(Vec3::UnitY()) : Vec3(-Vec3::UnitY());
}

}  // namespace

Grasp::Grasp(const InstrumentGeometry& geometry, double opening, const GraspFigures& figures)
    : geometry_(geometry), figures_(figures), opening_(opening) {
  if (!geometry.has_jaws() || !(geometry.grip_stiffness > 0) || !(geometry.face_stiffness > 0))
    throw InputError(std::string(name_of(geometry.kind)), "has no jaws that hold tissue",
                     "make grasps for graspers and forceps only");
}

void Grasp::release() {
  holds_.clear();
  bruises_.clear();
  sides_ = {};
  squeeze_ = 0;
  report_ = {};
}

void Grasp::release(double opening) {
  release();
  opening_ = std::clamp(opening, 0.0, geometry_.max_opening);
}

bool Grasp::holds(VertexId vertex) const {
  const auto at = std::lower_bound(holds_.begin(), holds_.end(), vertex,
                                   [](const Hold& hold, VertexId v) { return hold.vertex < v; });
  return at != holds_.end() && at->vertex == vertex;
}

/// Holds a vertex so that the face begins to press on it when it has come to the surface there.
void Grasp::add(const JawShare& share, const GraspStep& step) {
  Hold hold;
  hold.vertex = share.vertex;
  hold.side = share.side;
  hold.area = share.area;
  hold.anchor =
      jaw_pose(geometry_, step.from, opening_, share.side).inverse() * step.surface.positions[share.vertex.index()];
  hold.anchor -= (share.gap - side(share.side).level) * face_direction(share.side);
  holds_.push_back(hold);
}

/// Whether the jaws, closing, have come to tissue on both sides; then they hold it as it is.
bool Grasp::begin(const GraspStep& step) {
  const double wanted = std::clamp(step.opening, 0.0, geometry_.max_opening);
  const bool closing = wanted < opening_;
  if (!closing) {
    opening_ = wanted;
    return false;
  }
  look_into_mouth(geometry_, {step.from, opening_, 0, figures_.reach, figures_.reach}, step.surface, mouth_);
  // Tissue fills the angle between the places where it reaches furthest; the jaws meet it there, wherever it lies
  // between.
  const double filled = mouth_.extent_a + mouth_.extent_b;
  if (mouth_.empty() || filled + figures_.reach / geometry_.jaw_length < wanted) {
    opening_ = wanted;
    return false;
  }
  const double closed_to = std::clamp(filled, wanted, opening_);
  const double way = geometry_.jaw_length * std::sin((opening_ - closed_to) / 2) + figures_.reach;
  opening_ = closed_to;
  look_into_mouth(geometry_, {step.from, opening_, 0, way, figures_.reach}, step.surface, mouth_);
  for (const JawShare& share : mouth_.shares)
    if (share.near > 0) side(share.side).level = std::min(side(share.side).level, share.gap);
  for (const JawShare& share : mouth_.shares)
    if (share.near > 0) add(share, step);
  sum_areas();
  if (sides_[0].area > 0 && sides_[1].area > 0) return true;
  release();
  opening_ = wanted;
  return false;
}

/// What has slid out is lost, what has come between the faces is held too.
void Grasp::renew(const GraspStep& step) {
  look_into_mouth(geometry_, {step.from, opening_, figures_.slack, figures_.slack, figures_.reach}, step.surface,
                  mouth_);
  const auto& shares = mouth_.shares;
  const auto first_of = [&](VertexId v) {
    return std::lower_bound(shares.begin(), shares.end(), v,
                            [](const JawShare& s, VertexId x) { return s.vertex < x; });
  };
  std::erase_if(holds_, [&](const Hold& hold) {
    const auto at = first_of(hold.vertex);
    return at == shares.end() || at->vertex != hold.vertex;
  });
  for (Hold& hold : holds_) {
    double own = 0, other = 0;
    for (auto at = first_of(hold.vertex); at != shares.end() && at->vertex == hold.vertex; ++at)
      (at->side == hold.side ? own : other) += at->area;
    hold.area = std::max(own, 0.05 * other);  // in the other jaw's half for the moment: still held by this one
  }
  const std::size_t held = holds_.size();
  if (step.opening <= opening_)
    for (const JawShare& share : shares) {
      const auto same = [&](const Hold& h) { return h.vertex == share.vertex && h.side == share.side; };
      const auto end = holds_.begin() + static_cast<std::ptrdiff_t>(held);
      const auto at =
          std::lower_bound(holds_.begin(), end, share.vertex, [](const Hold& h, VertexId v) { return h.vertex < v; });
      const bool known = at != end && (same(*at) || (at + 1 != end && same(*(at + 1))));
      if (share.near > 0 && !known) add(share, step);
    }
  std::stable_sort(holds_.begin(), holds_.end(), [](const Hold& x, const Hold& y) {
    return x.vertex != y.vertex ? x.vertex < y.vertex : x.side < y.side;
  });
  sum_areas();
}

void Grasp::sum_areas() {
  for (Side& s : sides_) s.area = 0;
  for (const Hold& hold : holds_) side(hold.side).area += hold.area;
}

/// Thickness of what is held as a share of its thickness at rest; infinite where that is nothing.
double Grasp::squeezed_to(const GraspStep& step) const {
  Vec3 now = Vec3::Zero(), rest = Vec3::Zero();
  for (const Hold& hold : holds_) {
    const double weight = (hold.side == JawSide::b ? hold.area : -hold.area) / side(hold.side).area;
    now += weight * step.surface.positions[hold.vertex.index()];
    rest += weight * step.rest[hold.vertex.index()];
  }
  const double thickness = now.dot(step.from.rotation * Vec3::UnitY()), at_rest = rest.norm();
  return at_rest > 1e-6 ? thickness / at_rest : std::numeric_limits<double>::infinity();
}

/// Mean distance of what is held from the jaws' axis.
double Grasp::lever() const {
  double moment = 0, area = 0;
  for (const Hold& hold : holds_) {
    moment += hold.area * hold.anchor.z();
    area += hold.area;
  }
  return std::clamp(moment / area, geometry_.face_start, geometry_.jaw_length);
}

/// Closes until the faces press with the wanted grip, the tissue is as thin as it gets, or the hand stops. One Newton
/// step on the faces' stiffness alone: tissue gives way as well, so the grip is reached from below.
void Grasp::close_jaws(const GraspStep& step) {
  const double wanted = std::clamp(step.opening, 0.0, geometry_.max_opening);
  report_.at_thickness = false;
  if (wanted >= opening_) {
    opening_ = wanted;
    return;
  }
  const double missing = squeeze_ > 1.05 * grip_ ? grip_ - squeeze_ : std::max(0.0, grip_ - squeeze_);
  double next = opening_ - 2 * missing / (geometry_.face_stiffness * lever());
  const double thickness = squeezed_to(step);
  const double thinnest =
      thickness > figures_.least_thickness ? opening_ * figures_.least_thickness / thickness : opening_;
  if (next < thinnest) {
    next = thinnest;
    report_.at_thickness = true;
  }
  opening_ = std::clamp(next, wanted, geometry_.max_opening);
}

/// Where jaws and anchors are at the end of the step, and where the tissue would be if nothing held it.
void Grasp::place_jaws(const GraspStep& step) {
  for (const JawSide s : {JawSide::a, JawSide::b}) {
    side(s).pose = jaw_pose(geometry_, step.to, opening_, s);
    side(s).direction = side(s).pose.rotation * face_direction(s);
  }
  const Pose carried = step.to * step.from.inverse();  // tissue between the jaws goes along with them
  for (Hold& hold : holds_) {
    const std::size_t v = hold.vertex.index();
    hold.place = step.surface.positions[v] + step.step * step.velocities[v];
    hold.target = side(hold.side).pose * hold.anchor;
    hold.depth = (hold.target - carried * step.surface.positions[v]).dot(side(hold.side).direction);
  }
}

Vec3 Grasp::stretch_across(const Hold& hold) const {
  const Vec3 stretch = hold.target - hold.place;
  const Vec3& n = side(hold.side).direction;
  return stretch - stretch.dot(n) * n;
}

/// What friction carries at these forces of the faces: μ N of each jaw, shared by area. Together the jaws never press
/// harder than the grip that closes them.
void Grasp::press(double normal_a, double normal_b) {
  const double least = report_.at_thickness ? grip_ : 0.0;  // tissue that can't be squeezed carries what is missing
  sides_[0].normal = std::max(least, normal_a);
  sides_[1].normal = std::max(least, normal_b);
  const double mean = (sides_[0].normal + sides_[1].normal) / 2;
  if (mean > grip_)
    for (Side& s : sides_) s.normal *= grip_ / mean;
  for (Side& s : sides_) s.pressed = 0;
  for (const Hold& hold : holds_)
    if (hold.along > 0) side(hold.side).pressed += hold.area;
  for (Hold& hold : holds_) {
    const Side& s = side(hold.side);
    hold.limit = hold.along > 0 ? figures_.friction * s.normal * hold.area / s.pressed : 0;
  }
}

/// Stiffness of this step. Without a trial, where the expected stretch exceeds friction, the spring is softened so that
/// it gives just that friction there.
void Grasp::aim(bool trial) {
  std::array<double, 2> normal{0, 0};
  for (Hold& hold : holds_) {
    const Side& s = side(hold.side);
    hold.along = hold.depth > 0 ? geometry_.face_stiffness * hold.area / s.area : 0;
    normal[hold.side == JawSide::a ? 0 : 1] += hold.along * hold.depth;
  }
  press(normal[0], normal[1]);
  const double all = sides_[0].pressed + sides_[1].pressed;
  for (Hold& hold : holds_) {
    hold.across = hold.along > 0 ? geometry_.grip_stiffness * hold.area / all : 0;
    hold.slides = false;
    if (trial) continue;
    const double stretch = stretch_across(hold).norm();
    if (hold.across * stretch > hold.limit) hold.across = hold.limit / stretch;
  }
}

void Grasp::update(const GraspStep& step) {
  step_ = step.step;
  grip_ = std::clamp(step.grip, 0.0, geometry_.max_grip);
  pose_ = step.to;
  bruises_.clear();
  const bool opening = step.opening > opening_;
  if (holding()) {
    renew(step);
    if (!(sides_[0].area > 0 && sides_[1].area > 0)) {
      release();
      opening_ = std::clamp(step.opening, 0.0, geometry_.max_opening);
      return;
    }
    close_jaws(step);
  } else if (!begin(step)) {
    return;
  }
  place_jaws(step);
  aim(step.trial);
  if (opening && sides_[0].normal + sides_[1].normal <= 0) release();  // nothing is pressed on any more
}

/// A sliding hold pulls by its friction limit: a spring so soft, towards a place so far, that the force hardly changes.
Spring Grasp::spring_of(const Hold& hold) const {
  const Vec3& n = side(hold.side).direction;
  Spring spring;
  spring.vertex = hold.vertex;
  spring.anchor = hold.target;
  spring.stiffness = hold.across * Mat3::Identity() + (hold.along - hold.across) * n * n.transpose();
  if (hold.slides) spring.anchor += hold.pull;
  return spring;
}

double Grasp::excess(std::span<const Vec3> trial_positions) const {
  double beyond = 0, limit = 0;
  for (const Hold& hold : holds_) {
    const Vec3& n = side(hold.side).direction;
    const Vec3 stretch = hold.target - trial_positions[hold.vertex.index()];
    const double pull = hold.across * (stretch - stretch.dot(n) * n).norm();
    beyond += std::max(0.0, pull - hold.limit);
    limit += hold.limit;
  }
  return limit > 0 ? beyond / limit : 0;
}

bool Grasp::correct(std::span<const Vec3> trial_positions) {
  bool again = false;
  for (Hold& hold : holds_) {
    hold.place = trial_positions[hold.vertex.index()];
    const Vec3 stretch = stretch_across(hold);
    const double length = stretch.norm();
    if (hold.across * length <= 1.01 * hold.limit) continue;
    constexpr double soft = 1e-3;
    hold.across *= soft;
    hold.pull = hold.across > 0 ? Vec3((hold.limit / (hold.across * length) - 1) * stretch) : Vec3(Vec3::Zero());
    hold.slides = again = true;
  }
  return again;
}

void Grasp::springs(std::vector<Spring>& out) const {
  for (const Hold& hold : holds_) out.push_back(spring_of(hold));
}

/// Return mapping: where the pull across the face exceeds friction, the anchor follows the tissue until it is just
/// that.
void Grasp::slide() {
  const double all = sides_[0].pressed + sides_[1].pressed;
  report_.slip = 0;
  for (Hold& hold : holds_) {
    if (hold.along == 0) {  // nothing presses here: the tissue glides
      hold.anchor -= side(hold.side).pose.rotation.conjugate() * stretch_across(hold);
      continue;
    }
    const Vec3 stretch = stretch_across(hold);
    const double pull = geometry_.grip_stiffness * hold.area / all * stretch.norm();
    if (pull <= hold.limit) continue;
    const Vec3 slip = (1 - hold.limit / pull) * stretch;
    hold.anchor -= side(hold.side).pose.rotation.conjugate() * slip;
    report_.slip += slip.norm() * hold.area / all;
  }
  report_.slipped += report_.slip;
}

void Grasp::write_report() {
  report_.a = report_.b = {};
  for (const Hold& hold : holds_) (hold.side == JawSide::a ? report_.a : report_.b).force -= hold.force;
  for (const JawSide s : {JawSide::a, JawSide::b}) {
    JawReport& jaw = s == JawSide::a ? report_.a : report_.b;
    const Vec3& n = side(s).direction;
    jaw.normal = side(s).normal;
    jaw.tangential = (jaw.force - jaw.force.dot(n) * n).norm();
    jaw.area = side(s).pressed;
  }
  report_.pull = report_.a.force + report_.b.force;
  report_.grip = (report_.a.normal + report_.b.normal) / 2;
  report_.hold_limit = 2 * figures_.friction * report_.grip;
  for (const Hold& hold : holds_) {
    const Side& s = side(hold.side);
    if (hold.along == 0 || (s.normal <= figures_.damage_grip && s.normal <= figures_.damage_pressure * s.pressed))
      continue;
    bruises_.push_back({hold.vertex, s.normal * hold.area / s.pressed, hold.area, step_});
  }
}

void Grasp::after_step(std::span<const Vec3> positions) {
  if (!holding()) return;
  std::array<double, 2> normal{0, 0};
  for (Hold& hold : holds_) {
    hold.place = positions[hold.vertex.index()];
    const Spring spring = spring_of(hold);
    hold.force = spring.stiffness * (spring.anchor - hold.place);
    normal[hold.side == JawSide::a ? 0 : 1] += hold.force.dot(side(hold.side).direction);
  }
  squeeze_ = (normal[0] + normal[1]) / 2;
  press(normal[0], normal[1]);
  slide();
  write_report();
}

void Grasp::follow(const Remap& remap, std::span<const Vec3> before, std::span<const Vec3> after) {
  if (!holding()) return;
  const std::vector<Hold> old = std::move(holds_);
  holds_.clear();
  const auto keep = [&](const Hold& hold, VertexId now) {
    holds_.push_back(hold);
    holds_.back().vertex = now;
    // The place that is held may have moved along the tissue; the spring keeps its stretch.
    const Pose& jaw = side(hold.side).pose;
    holds_.back().anchor += jaw.rotation.conjugate() * (after[now.index()] - before[hold.vertex.index()]);
  };
  for (const Hold& hold : old)
    if (const VertexId now = remap.vertex_to_new[hold.vertex.index()]; now.valid()) keep(hold, now);
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    const AddedVertex& added = remap.added_from[k];
    const VertexId nearest = added.weight <= 0.5 ? added.from : added.to;
    auto at =
        std::lower_bound(old.begin(), old.end(), nearest, [](const Hold& hold, VertexId v) { return hold.vertex < v; });
    for (; at != old.end() && at->vertex == nearest; ++at) {
      keep(*at, remap.added_vertices[k]);
      holds_.back().force.setZero();  // it wasn't there in the last step
    }
  }
  std::stable_sort(holds_.begin(), holds_.end(), [](const Hold& x, const Hold& y) {
    return x.vertex != y.vertex ? x.vertex < y.vertex : x.side < y.side;
  });
  sum_areas();
  if (!(sides_[0].area > 0 && sides_[1].area > 0)) release();
}

Vector6 Grasp::wrench() const {
  Vector6 sum = Vector6::Zero();
  for (const Hold& hold : holds_) {
    sum.head<3>() -= hold.force;
    sum.tail<3>() -= (hold.target - pose_.position).cross(hold.force);
  }
  return sum;
}

Matrix6 Grasp::stiffness() const {
  Matrix6 sum = Matrix6::Zero();
  for (const Hold& hold : holds_) {
    const Vec3 r = hold.target - pose_.position;
    Eigen::Matrix<double, 3, 6> motion;  // of the anchor, per twist of the instrument
    motion.leftCols<3>().setIdentity();
    motion.rightCols<3>() << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0;
    sum += motion.transpose() * spring_of(hold).stiffness * motion;
  }
  return sum;
}

void Grasp::append_state(std::string& bytes) const {
  for (const double value : {opening_, grip_, squeeze_, report_.slipped, sides_[0].level, sides_[1].level})
    detail::append_bytes(bytes, value);
  detail::append_bytes(bytes, pose_);
  detail::append_bytes(bytes, holds_.size());
  for (const Hold& hold : holds_) {
    detail::append_bytes(bytes, hold.vertex.value);
    detail::append_bytes(bytes, hold.side);
    detail::append_bytes(bytes, hold.anchor);
    detail::append_bytes(bytes, hold.area);
    detail::append_bytes(bytes, hold.force);
  }
}

}  // namespace calot
