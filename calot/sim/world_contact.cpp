// Contacts of a step: found, solved with friction, answered by the tissue, and handed to haptic loops.
#include <algorithm>

#include "calot/sim/world.h"
#include "calot/sim/world_clock.h"

namespace calot {
namespace {

using Index = Eigen::Index;

// Both sides of a contact as one set of weighted vertices.
ContactRows rows_of(const TissueContact& contact) {
  ContactRows rows;
  rows.frame = contact_frame(contact.normal).transpose();
  const auto add = [&](const SurfacePoint& point, double sign) {
    for (std::size_t i = 0; i < 3; ++i) {
      rows.vertices[rows.count] = point.vertices[i];
      rows.weights[rows.count++] = sign * point.weights[static_cast<Index>(i)];
    }
  };
  add(contact.point, 1);
  if (contact.partner == ContactPartner::tissue) add(contact.other, -1);
  return rows;
}

Vec3 motion_at(const ContactRows& rows, std::span<const Vec3> d) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < rows.count; ++i) sum += rows.weights[i] * d[rows.vertices[i].index()];
  return sum;
}

bool share_part(const ContactRows& a, const ContactRows& b, std::span<const std::uint32_t> parts) {
  for (std::size_t i = 0; i < a.count; ++i)
    for (std::size_t j = 0; j < b.count; ++j)
      if (parts[a.vertices[i].index()] == parts[b.vertices[j].index()]) return true;
  return false;
}

Mat3 cross_matrix(const Vec3& r) {
  Mat3 m;
  m << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return m;
}

}  // namespace

// Blades that cut leave no room for themselves; they touch again once all of them is out of the tissue: sooner, it
// would be torn off the backs of blades that are opened in the wound.
void World::withdraw_blades() {
  for (InstrumentArm& arm : arms_) {
    if (!arm.in_cut || arm.closing()) continue;
    surface_.refit(state_.positions, {}, options_.contact.margin);
    const ArticulatedPoses parts = articulate(arm.geometry(), arm.opening_from());
    arm.in_cut = !is_clear(arm.geometry().jaw_a, arm.from() * parts.jaw_a) ||
                 !is_clear(arm.geometry().jaw_b, arm.from() * parts.jaw_b);
  }
}

// Points two millimetres apart on every piece, each at least the piece's radius outside. After a refit.
bool World::is_clear(const RigidShape& shape, const Pose& pose) const {
  constexpr double spacing = 2e-3;
  for (const RoundedPiece& piece : shape.pieces) {
    std::array<Vec3, 3> x;
    for (std::size_t c = 0; c < 3; ++c) x[c] = pose * piece.corners[std::min<std::size_t>(c, piece.corner_count - 1)];
    const double size = std::max((x[1] - x[0]).norm(), (x[2] - x[0]).norm());
    const int count = 1 + static_cast<int>(size / spacing);
    for (int i = 0; i <= count; ++i)
      for (int j = 0; i + j <= count; ++j)
        if (surface_.nearest(x[0] + (i * (x[1] - x[0]) + j * (x[2] - x[0])) / count).distance < piece.radius)
          return false;
  }
  return true;
}

void World::find_contacts() {
  withdraw_blades();
  shapes_.clear();
  shape_owner_.clear();
  std::vector<std::uint8_t> parts;
  for (std::size_t k = 0; k < arms_.size(); ++k) {
    arms_[k].add_shapes(shapes_, parts);
    for (std::size_t p = shape_owner_.size(); p < parts.size(); ++p)
      shape_owner_.emplace_back(static_cast<std::uint32_t>(k), parts[p]);
  }
  contacts_ = detect(surface_, state_.positions, motion_of_step_, {shapes_, still_}, options_.contact);
  for (TissueContact& contact : contacts_)
    if (contact.partner == ContactPartner::shape && !arms_[shape_owner_[contact.shape].first].setup().friction)
      contact.friction = properties_.at(model_.mesh().regions[contact.point.tet.index()]).friction;
  if (!lost_.empty())
    std::erase_if(contacts_, [&](const TissueContact& contact) {
      return is_lost(contact.point.vertices[0]) ||
             (contact.partner == ContactPartner::tissue && is_lost(contact.other.vertices[0]));
    });
  // Tissue turned inside out has its surface inside too: met by itself there, it could never unfold.
  const auto inside_out = [&](TetId t) {
    const Tet& tet = model_.mesh().tet(t);
    const std::vector<Vec3>& x = state_.positions;
    return !(signed_volume(x[tet[0].index()], x[tet[1].index()], x[tet[2].index()], x[tet[3].index()]) > 0);
  };
  std::erase_if(contacts_, [&](const TissueContact& contact) {
    return contact.partner == ContactPartner::tissue &&
           (inside_out(contact.point.tet) || inside_out(contact.other.tet));
  });
  // Held tissue is the grasp's business.
  std::erase_if(contacts_, [&](const TissueContact& contact) {
    if (contact.partner != ContactPartner::shape) return false;
    const InstrumentArm& arm = arms_[shape_owner_[contact.shape].first];
    return arm.grasp && std::any_of(contact.point.vertices.begin(), contact.point.vertices.end(),
                                    [&](VertexId v) { return arm.grasp->holds(v); });
  });
}

// What a contact's gap is taken for: of an overlap, what this step shall undo. Tissue in tissue parts gently: undone at
// once, overlaps of rough cut faces would kick them.
double World::gap_of_step(const TissueContact& contact) const {
  constexpr double share_in_tissue = 0.2;
  if (contact.gap >= 0) return contact.gap;
  return std::max(contact.partner == ContactPartner::tissue ? share_in_tissue * contact.gap : contact.gap,
                  -options_.recovery);
}

void World::solve_contacts(PhaseClock& clock) {
  report_.contacts = contacts_.size();
  contact_forces_.clear();
  push_.clear();
  for (InstrumentArm& arm : arms_) arm.force.setZero();
  report_.response.converged = report_.friction.converged = true;
  problem_ = {};
  rows_.clear();
  if (contacts_.empty()) {
    warm_.clear();
    clock.end(Phase::contact);
    return;
  }
  const auto size = 3 * static_cast<Index>(contacts_.size());
  std::vector<double> start(static_cast<std::size_t>(size), 0.0);
  problem_.free_motion.resize(size);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const TissueContact& contact = contacts_[k];
    rows_.push_back(rows_of(contact));
    Vec3 q = rows_[k].frame.transpose() * (motion_at(rows_[k], motion_of_step_) - contact.partner_motion);
    q.x() += gap_of_step(contact);
    report_.deepest_overlap = std::max(report_.deepest_overlap, -contact.gap);
    problem_.free_motion.segment<3>(3 * static_cast<Index>(k)) = q;
    problem_.friction.push_back(contact.friction);
    if (const auto before = warm_.find(contact.key); before != warm_.end())
      for (std::size_t i = 0; i < 3; ++i) start[3 * k + i] = before->second[static_cast<Index>(i)];
  }
  problem_.delassus = compliance_.present().delassus(rows_);
  if (motion_.part_count() > 1)
    for (std::size_t k = 0; k < rows_.size(); ++k)
      for (std::size_t m = 0; m < k; ++m)
        if (!share_part(rows_[k], rows_[m], motion_.parts())) {
          problem_.delassus.block<3, 3>(3 * static_cast<Index>(k), 3 * static_cast<Index>(m)).setZero();
          problem_.delassus.block<3, 3>(3 * static_cast<Index>(m), 3 * static_cast<Index>(k)).setZero();
        }
  report_.friction = solve_friction(problem_, start, options_.friction);
  clock.end(Phase::contact);

  contact_forces_.assign(state_.positions.size(), Vec3::Zero());
  warm_.clear();
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Vec3 local = report_.friction.forces.segment<3>(3 * static_cast<Index>(k));
    warm_[contacts_[k].key] = local;
    const Vec3 force = rows_[k].frame * local;
    for (std::size_t i = 0; i < rows_[k].count; ++i)
      contact_forces_[rows_[k].vertices[i].index()] += rows_[k].weights[i] * force;
    if (contacts_[k].partner == ContactPartner::shape) arms_[shape_owner_[contacts_[k].shape].first].force -= force;
  }
  for (std::size_t v = 0; v < contact_forces_.size(); ++v)
    if (model_.is_fixed(VertexId(v))) contact_forces_[v].setZero();
  report_.response = motion_.add_response(contact_forces_, preconditioner(), options_.solver, motion_of_step_);
  // What the contacts really came to: the compliance they were solved with is an approximation once tissue has turned.
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const double gap = gap_of_step(contacts_[k]) +
                       contacts_[k].normal.dot(motion_at(rows_[k], motion_of_step_) - contacts_[k].partner_motion);
    report_.contact_error = std::max(report_.contact_error, -gap);
  }
  find_push();
  clock.end(Phase::response);
}

// A part without contact forces gets no trace of the others' push either.
void World::keep_parts_apart() {
  if (motion_.part_count() == 1) return;
  std::vector<std::uint8_t> touched(motion_.part_count(), 0);
  const std::span<const std::uint32_t> parts = motion_.parts();
  for (std::size_t v = 0; v < contact_forces_.size(); ++v)
    if (!contact_forces_[v].isZero(0)) touched[parts[v]] = 1;
  for (std::size_t v = 0; v < push_.size(); ++v)
    if (!touched[parts[v]]) push_[v].setZero();
}

// Overlaps are undone as a shift of place, which is no velocity: `push_` is what the motion would be without it less.
// Its forces: those of the contacts less those they would need had they not to part by what they really parted by.
void World::find_push() {
  constexpr double least = 1e-6;  // [m]
  FrictionProblem eased = problem_;
  double most = 0;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const double overlap = -gap_of_step(contacts_[k]);
    if (!(overlap > 0)) continue;
    const double parted = contacts_[k].normal.dot(motion_at(rows_[k], motion_of_step_) - contacts_[k].partner_motion);
    const double undone = std::min(overlap, parted);
    if (!(undone > 0)) continue;
    most = std::max(most, undone);
    eased.free_motion[3 * static_cast<Index>(k)] += undone;
  }
  if (most <= least) return;
  const Eigen::VectorXd& forces = report_.friction.forces;
  const FrictionSolution without =
      solve_friction(eased, {forces.data(), static_cast<std::size_t>(forces.size())}, options_.friction);
  std::vector<Vec3> difference(contact_forces_.size(), Vec3::Zero());
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const auto at = 3 * static_cast<Index>(k);
    const Vec3 force = rows_[k].frame * (forces.segment<3>(at) - without.forces.segment<3>(at));
    for (std::size_t i = 0; i < rows_[k].count; ++i)
      if (const VertexId v = rows_[k].vertices[i]; !model_.is_fixed(v))
        difference[v.index()] += rows_[k].weights[i] * force;
  }
  push_.resize(difference.size());
  compliance_.present().apply(difference, push_);
  keep_parts_apart();
}

// The contacts with this instrument alone; what the others do is part of the free motion.
void World::haptic_constraints(std::size_t instrument, HapticConstraints& out) const {
  const InstrumentArm& arm = arms_[instrument];
  out.step = step_;
  out.pose = arm.to();
  std::vector<Index> mine;
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    if (contacts_[k].partner == ContactPartner::shape && shape_owner_[contacts_[k].shape].first == instrument)
      mine.push_back(static_cast<Index>(k));
  const auto count = static_cast<Index>(mine.size());
  out.problem.delassus.resize(3 * count, 3 * count);
  out.problem.free_motion.resize(3 * count);
  out.problem.friction.resize(mine.size());
  out.motion.resize(3 * count, 6);
  out.wrench.resize(6, 3 * count);
  const Eigen::VectorXd moved =
      contacts_.empty() ? Eigen::VectorXd()
                        : Eigen::VectorXd(problem_.free_motion + problem_.delassus * report_.friction.forces);
  for (Index k = 0; k < count; ++k) {
    const TissueContact& contact = contacts_[static_cast<std::size_t>(mine[static_cast<std::size_t>(k)])];
    const ContactRows& rows = rows_[static_cast<std::size_t>(mine[static_cast<std::size_t>(k)])];
    Vec3 own = Vec3::Zero();
    for (Index m = 0; m < count; ++m) {
      const Mat3 block =
          problem_.delassus.block<3, 3>(3 * mine[static_cast<std::size_t>(k)], 3 * mine[static_cast<std::size_t>(m)]);
      out.problem.delassus.block<3, 3>(3 * k, 3 * m) = block;
      own += block * report_.friction.forces.segment<3>(3 * mine[static_cast<std::size_t>(m)]);
    }
    out.problem.free_motion.segment<3>(3 * k) = moved.segment<3>(3 * mine[static_cast<std::size_t>(k)]) - own;
    out.problem.friction[static_cast<std::size_t>(k)] = contact.friction;
    const Vec3 arm_of_force = contact.place + contact.partner_motion - out.pose.position;
    out.motion.block<3, 3>(3 * k, 0) = -rows.frame.transpose();
    out.motion.block<3, 3>(3 * k, 3) = rows.frame.transpose() * cross_matrix(arm_of_force);
    out.wrench.block<3, 3>(0, 3 * k) = -rows.frame;
    out.wrench.block<3, 3>(3, 3 * k) = -cross_matrix(arm_of_force) * rows.frame;
  }
  out.held_wrench = arm.grasp ? arm.grasp->wrench() : Vector6(Vector6::Zero());
  out.held_stiffness = arm.grasp ? arm.grasp->stiffness() : Matrix6(Matrix6::Zero());
  if (arm.held_clip < 0) return;
  const Vec3 r = arm.to() * arm.clip_anchor - arm.to().position;
  out.held_wrench.head<3>() -= arm.clip_pull;
  out.held_wrench.tail<3>() -= r.cross(arm.clip_pull);
  Eigen::Matrix<double, 3, 6> motion;  // of the clip's anchor, per twist
  motion << Mat3::Identity(), -cross_matrix(r);
  out.held_stiffness += arm.geometry().grip_stiffness * motion.transpose() * motion;
}

}  // namespace calot
