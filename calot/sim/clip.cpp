#include "calot/sim/clip.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "calot/base/error.h"
#include "calot/sim/instrument_state.h"

namespace calot {
namespace {

constexpr double tip_beyond_clip = 0.5e-3;  // the jaws reach this far beyond the legs' ends [m]

/// How much each vertex takes part in wall a and in wall b.
struct Walls {
  VertexId vertex;
  double a = 0, b = 0;
};

std::vector<Walls> walls_of(const std::vector<ClipStation>& stations) {
  std::vector<Walls> walls;
  for (const ClipStation& station : stations)
    for (int k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      walls.push_back({station.a.vertices[i], station.a.weights[k], 0});
      walls.push_back({station.b.vertices[i], 0, station.b.weights[k]});
    }
  std::stable_sort(walls.begin(), walls.end(), [](const Walls& x, const Walls& y) { return x.vertex < y.vertex; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < walls.size(); ++i)
    if (kept > 0 && walls[kept - 1].vertex == walls[i].vertex) {
      walls[kept - 1].a += walls[i].a;
      walls[kept - 1].b += walls[i].b;
    } else {
      walls[kept++] = walls[i];
    }
  walls.resize(kept);
  return walls;
}

const Walls& wall_of(const std::vector<Walls>& walls, VertexId v) {
  return *std::lower_bound(walls.begin(), walls.end(), v, [](const Walls& w, VertexId x) { return w.vertex < x; });
}

/// Which of the closed clip's planes a vertex comes to: −1 wall a, 1 wall b, 0 between, where the walls meet.
double plane_of(const Walls& wall) {
  if (std::min(wall.a, wall.b) > 0.2 * std::max(wall.a, wall.b)) return 0;
  return wall.a > wall.b ? -1 : 1;
}

/// What the vertices of an edit's old mesh became: the survivor, then what was added nearest to it.
class Successors {
 public:
  explicit Successors(const Remap& remap) : remap_(remap) {
    for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
      const AddedVertex& added = remap.added_from[k];
      added_.emplace_back(added.weight <= 0.5 ? added.from : added.to, remap.added_vertices[k]);
    }
    std::sort(added_.begin(), added_.end());
  }
  [[nodiscard]] std::vector<VertexId> of(VertexId old) const {
    std::vector<VertexId> now;
    if (const VertexId survivor = remap_.vertex_to_new[old.index()]; survivor.valid()) now.push_back(survivor);
    for (auto at = std::lower_bound(added_.begin(), added_.end(), std::pair(old, VertexId(0)));
         at != added_.end() && at->first == old; ++at)
      now.push_back(at->second);
    return now;
  }

 private:
  const Remap& remap_;
  std::vector<std::pair<VertexId, VertexId>> added_;
};

}  // namespace

Clip::Clip(const ClipFigures& figures, const InstrumentGeometry& applier, const Pose& pose, double opening,
           const TissueSurface& surface, const TetMesh& mesh)
    : figures_(figures) {
  if (applier.kind != InstrumentKind::clip_applier)
    throw InputError(std::string(name_of(applier.kind)), "has no clips", "fire clips with a clip applier");
  const double middle = applier.jaw_length - tip_beyond_clip - figures.leg_length / 2, slope = std::tan(opening / 2);
  frame_ = {pose.rotation, pose * Vec3(0, 0, middle)};
  turn_ = frame_.rotation;
  stations_ = clip_stations(figures_, frame_, middle * slope, slope, surface);
  if (stations_.empty()) {
    come_off();
    return;
  }
  closed_gap_ = std::max(figures_.closed_gap, figures_.least_thickness * gap());
  make_pairs(surface.positions);
  gather(surface.positions);
  tets_ = clip_tets(figures_, frame_, middle * slope, slope, mesh, surface.positions);
  std::set<std::int32_t> regions;
  for (const TetId t : tets_) regions.insert(mesh.regions[t.index()]);
  whole_ = std::any_of(regions.begin(), regions.end(), [&](std::int32_t region) {
    return spans(region, middle * slope, slope, mesh, surface.positions);
  });
  if (pairs_.empty()) come_off();
}

/// Springs between all corners of the triangles where each line enters and leaves: so the force on a wall acts where
/// the line meets it, and both walls feel the same force.
void Clip::make_pairs(std::span<const Vec3> positions) {
  const std::vector<Walls> walls = walls_of(stations_);
  const double each = figures_.stiffness / static_cast<double>(stations_.size());
  for (const ClipStation& station : stations_)
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        Pair pair;
        pair.a = station.a.vertices[static_cast<std::size_t>(i)];
        pair.b = station.b.vertices[static_cast<std::size_t>(k)];
        pair.stiffness = each * station.a.weights[i] * station.b.weights[k];
        if (pair.a == pair.b || pair.stiffness <= 0) continue;
        pair.offset = frame_.rotation.conjugate() * (positions[pair.b.index()] - positions[pair.a.index()]);
        const double apart = (plane_of(wall_of(walls, pair.b)) - plane_of(wall_of(walls, pair.a))) * closed_gap_ / 2;
        pair.closed = std::min(pair.offset.y(), apart);
        pairs_.push_back(pair);
      }
  std::stable_sort(pairs_.begin(), pairs_.end(),
                   [](const Pair& x, const Pair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    if (kept > 0 && pairs_[kept - 1].a == pairs_[i].a && pairs_[kept - 1].b == pairs_[i].b)
      pairs_[kept - 1].stiffness += pairs_[i].stiffness;
    else
      pairs_[kept++] = pairs_[i];
  pairs_.resize(kept);
}

/// The vertices that the frame follows, as they lie in it now.
void Clip::gather(std::span<const Vec3> positions) {
  held_.clear();
  double sum = 0;
  for (const Walls& wall : walls_of(stations_)) {
    if (wall.a + wall.b <= 0) continue;
    held_.push_back({wall.vertex, wall.a + wall.b, frame_.inverse() * positions[wall.vertex.index()]});
    sum += wall.a + wall.b;
  }
  for (Held& held : held_) held.weight /= sum;
}

Vec3 Clip::target(const Pair& pair) const {
  return {pair.offset.x(), pair.offset.y() + progress_ * (pair.closed - pair.offset.y()), pair.offset.z()};
}

void Clip::springs(double step, std::vector<Spring>& out) {
  if (state_ == ClipState::off) return;
  time_ += step;
  if (state_ == ClipState::closing && closing_force_ < figures_.closing_force)
    progress_ = std::min(1.0, progress_ + step / figures_.closing_time);
  for (const Pair& pair : pairs_) {
    Spring spring;
    spring.vertex = pair.b;
    spring.other = pair.a;
    spring.anchor = turn_ * target(pair);
    spring.stiffness = pair.stiffness * Mat3::Identity();
    out.push_back(spring);
  }
}

void Clip::loads(std::span<Vec3> forces) const {
  if (state_ == ClipState::off) return;
  for (const Held& held : held_) forces[held.vertex.index()] += held.weight * load_;
}

/// Best rigid fit of the held vertices, weighted; the rotation from the last one on [Mueller2016].
void Clip::fit(std::span<const Vec3> positions) {
  Vec3 centre = Vec3::Zero(), place = Vec3::Zero();
  for (const Held& held : held_) {
    centre += held.weight * positions[held.vertex.index()];
    place += held.weight * held.place;
  }
  constexpr int most = 100;  // a step's turn takes two or three
  for (int k = 0; k < most; ++k) {
    Vec3 turn = Vec3::Zero();
    double size = 0;
    for (const Held& held : held_) {
      const Vec3 wanted = frame_.rotation * (held.place - place), is = positions[held.vertex.index()] - centre;
      turn += held.weight * wanted.cross(is);
      size += held.weight * wanted.dot(is);
    }
    turn /= std::abs(size) + 1e-12;
    const double angle = turn.norm();
    if (angle < 1e-9) break;
    frame_.rotation = (Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * frame_.rotation).normalized();
  }
  frame_.position = centre - frame_.rotation * place;
}

/// Forces that pull pairs apart or together may turn the tissue between them as a whole; in a frame that goes along
/// with it they would turn it for ever. At the rotation R that makes Σ k |x_b − x_a − R t|² least they don't: its
/// derivative is Σ k (x_b − x_a) × R t, the torque. Found by Newton's steps; turns that the pairs hardly feel are
/// damped.
void Clip::turn_springs(std::span<const Vec3> positions) {
  constexpr int most = 20;
  for (int k = 0; k < most; ++k) {
    Vec3 torque = Vec3::Zero();
    Mat3 resistance = Mat3::Zero();
    for (const Pair& pair : pairs_) {
      const Vec3 wanted = turn_ * target(pair), is = positions[pair.b.index()] - positions[pair.a.index()];
      torque += pair.stiffness * wanted.cross(is);
      const Mat3 across = is * wanted.transpose();
      resistance += pair.stiffness * (wanted.dot(is) * Mat3::Identity() - (across + across.transpose()) / 2);
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> turning(resistance);
    const double least = 1e-4 * turning.eigenvalues().cwiseAbs().maxCoeff();
    if (!(least > 0)) return;
    const Vec3 turn =
        turning.eigenvectors() *
        (turning.eigenvectors().transpose() * torque).cwiseQuotient(turning.eigenvalues().cwiseAbs().cwiseMax(least));
    const double angle = turn.norm();
    if (angle < 1e-10) return;
    turn_ = (Eigen::Quaterniond(Eigen::AngleAxisd(std::min(angle, 0.5), turn / angle)) * turn_).normalized();
  }
}

void Clip::measure_gaps(std::span<const Vec3> positions) {
  Vec3 y = frame_.rotation * Vec3::UnitY();
  for (ClipStation& station : stations_)
    station.gap = y.dot(place_of(station.b, positions) - place_of(station.a, positions));
  closing_force_ = 0;
  y = turn_ * Vec3::UnitY();
  for (const Pair& pair : pairs_)
    closing_force_ +=
        pair.stiffness * (y.dot(positions[pair.b.index()] - positions[pair.a.index()]) - target(pair).y());
}

/// Pull along and across the tube together, as on an ellipse; a clip that isn't round the whole tube, or doesn't press
/// its walls together, holds less.
void Clip::judge_pull() {
  const Vec3 pull = frame_.rotation.conjugate() * load_;
  const double share = whole_ && (state_ == ClipState::closing || together()) ? 1 : figures_.loose_share;
  strain_ = std::hypot(pull.x() / figures_.axial, std::hypot(pull.y(), pull.z()) / figures_.transverse) / share;
  load_.setZero();
  if (strain_ >= 1) come_off();
}

void Clip::after_step(std::span<const Vec3> positions) {
  if (state_ == ClipState::off) return;
  fit(positions);
  turn_springs(positions);
  measure_gaps(positions);
  if (state_ == ClipState::closing && (progress_ >= 1 || time_ >= 2 * figures_.closing_time)) {
    state_ = ClipState::closed;  // the wire keeps its shape: no closer any more
    gather(positions);
  }
  judge_pull();
}

void Clip::come_off() {
  state_ = ClipState::off;
  stations_.clear();
  pairs_.clear();
  held_.clear();
  tets_.clear();
  load_.setZero();
  closing_force_ = 0;
}

double Clip::gap() const {
  double most = 0;
  for (const ClipStation& station : stations_) most = std::max(most, station.gap);
  return most;
}

double Clip::held_area() const {
  double area = 0;
  for (const ClipStation& station : stations_) area += station.area;
  return area;
}

bool Clip::together() const {
  return gap() <= std::min(closed_gap_ + figures_.gap_tolerance, figures_.most_gap);
}

/// Whether the tube's whole section lies between the legs; what they press on may reach as far as their middle.
bool Clip::spans(std::int32_t region, double reach, double slope, const TetMesh& mesh,
                 std::span<const Vec3> positions) const {
  const ClipSection section = clip_section(frame_, reach, slope, tets_, region, mesh, positions);
  return section.tets > 0 && section.beyond <= figures_.wire && section.low_z >= -figures_.leg_length / 2 &&
         section.high_z <= figures_.leg_length / 2;
}

bool Clip::closes(std::int32_t region, const TetMesh& mesh, std::span<const Vec3> positions) const {
  const double half = std::max(gap(), closed_gap_) / 2;
  return state_ == ClipState::closed && together() && spans(region, half + figures_.wire, 0, mesh, positions);
}

bool Clip::holds(VertexId vertex) const {
  const auto at = std::lower_bound(held_.begin(), held_.end(), vertex,
                                   [](const Held& held, VertexId v) { return held.vertex < v; });
  return at != held_.end() && at->vertex == vertex;
}

void Clip::follow_tets(const Remap& remap) {
  std::vector<TetId> now;
  for (const TetId t : tets_)
    if (remap.tet_to_new[t.index()].valid()) now.push_back(remap.tet_to_new[t.index()]);
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
    if (std::binary_search(tets_.begin(), tets_.end(), remap.added_parents[k])) now.push_back(remap.added_tets[k]);
  std::sort(now.begin(), now.end());
  tets_ = std::move(now);
}

void Clip::follow(const Remap& remap, std::span<const Vec3> before, std::span<const Vec3> after) {
  if (state_ == ClipState::off) return;
  const Successors successors(remap);
  const auto shift = [&](const Eigen::Quaterniond& turn, VertexId old, VertexId now) -> Vec3 {
    return turn.conjugate() * (after[now.index()] - before[old.index()]);
  };
  std::vector<Pair> pairs;
  for (const Pair& pair : pairs_) {
    const std::vector<VertexId> a = successors.of(pair.a), b = successors.of(pair.b);
    if (a.empty() || b.empty()) continue;
    // A split doubles both walls in the same order; where only one was doubled, its copies share the other wall.
    // Together they are as stiff as before, and each is stretched as before: so the force stays, too.
    const std::size_t count = std::max(a.size(), b.size());
    for (std::size_t k = 0; k < count; ++k) {
      Pair now = pair;
      now.a = a[std::min(k, a.size() - 1)];
      now.b = b[std::min(k, b.size() - 1)];
      now.stiffness /= static_cast<double>(count);
      const Vec3 moved = shift(turn_, pair.b, now.b) - shift(turn_, pair.a, now.a);
      now.offset += moved;
      now.closed += moved.y();
      pairs.push_back(now);
    }
  }
  pairs_ = std::move(pairs);
  std::stable_sort(pairs_.begin(), pairs_.end(),
                   [](const Pair& x, const Pair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  std::vector<Held> held;
  double sum = 0;
  for (const Held& h : held_) {
    const std::vector<VertexId> heirs = successors.of(h.vertex);
    for (const VertexId now : heirs)
      held.push_back(
          {now, h.weight / static_cast<double>(heirs.size()), h.place + shift(frame_.rotation, h.vertex, now)});
    if (!heirs.empty()) sum += h.weight;
  }
  for (Held& h : held) h.weight /= sum;
  std::stable_sort(held.begin(), held.end(), [](const Held& x, const Held& y) { return x.vertex < y.vertex; });
  held_ = std::move(held);
  std::erase_if(stations_, [&](ClipStation& station) {
    for (SurfacePoint* point : {&station.a, &station.b})
      for (VertexId& v : point->vertices) {
        const std::vector<VertexId> now = successors.of(v);
        if (now.empty()) return true;
        v = now.front();
      }
    return false;
  });
  follow_tets(remap);
  if (pairs_.empty() || stations_.empty()) come_off();
}

RigidShape Clip::shape() const {
  const double y = std::max(gap(), closed_gap_) / 2 + figures_.wire, half = figures_.leg_length / 2;
  const Vec3 a0(0, -y, -half), a1(0, -y, half), b0(0, y, -half), b1(0, y, half);
  return {{{{a0, a1, a1}, 2, figures_.wire}, {{b0, b1, b1}, 2, figures_.wire}, {{a0, b0, b0}, 2, figures_.wire}}};
}

void Clip::append_state(std::string& bytes) const {
  detail::append_bytes(bytes, state_);
  detail::append_bytes(bytes, frame_);
  for (int k = 0; k < 4; ++k) detail::append_bytes(bytes, turn_.coeffs()[k]);
  for (const double value : {progress_, time_, closed_gap_, closing_force_, strain_})
    detail::append_bytes(bytes, value);
  detail::append_bytes(bytes, whole_);
  detail::append_bytes(bytes, load_);
  detail::append_bytes(bytes, pairs_.size());
  for (const Pair& pair : pairs_) {
    detail::append_bytes(bytes, pair.a.value);
    detail::append_bytes(bytes, pair.b.value);
    detail::append_bytes(bytes, pair.stiffness);
    detail::append_bytes(bytes, pair.offset);
    detail::append_bytes(bytes, pair.closed);
  }
  for (const Held& held : held_) {
    detail::append_bytes(bytes, held.vertex.value);
    detail::append_bytes(bytes, held.weight);
    detail::append_bytes(bytes, held.place);
  }
  for (const ClipStation& station : stations_) detail::append_bytes(bytes, station.gap);
}

std::vector<std::pair<VertexId, double>> Clip::held() const {
  std::vector<std::pair<VertexId, double>> result;
  for (const Held& held : held_) result.emplace_back(held.vertex, held.weight);
  return result;
}

double spacing(const Clip& a, const Clip& b) {
  return (a.frame().position - b.frame().position).norm();
}

}  // namespace calot
