#include "calot/view/snapshot_maker.h"

#include <algorithm>
#include <limits>

namespace calot {
namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// Corners of the step's first mesh that a vertex depends on, so far as tets hold them: an edge's ends, or more after
/// several edits in one step.
using Origins = std::vector<VertexId>;

void add(Origins& to, const Origins& more) {
  for (const VertexId v : more)
    if (std::find(to.begin(), to.end(), v) == to.end()) to.push_back(v);
}

/// Each vertex's origins after one more edit.
std::vector<Origins> origins_after(const Remap& remap, const std::vector<Origins>& before) {
  std::vector<Origins> after(remap.vertex_to_old.size());
  for (std::size_t v = 0; v < after.size(); ++v)
    if (remap.vertex_to_old[v].valid()) after[v] = before[remap.vertex_to_old[v].index()];
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    const AddedVertex& added = remap.added_from[k];
    Origins& own = after[remap.added_vertices[k].index()];
    if (added.weight < 1) add(own, before[added.from.index()]);
    if (added.weight > 0) add(own, before[added.to.index()]);
  }
  return after;
}

/// The tet of the step's first mesh that each tet is, or is a piece of.
std::vector<TetId> roots_after(const Remap& remap, const std::vector<TetId>& before) {
  std::vector<TetId> after(remap.tet_to_old.size());
  for (std::size_t t = 0; t < after.size(); ++t)
    if (remap.tet_to_old[t].valid()) after[t] = before[remap.tet_to_old[t].index()];
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
    after[remap.added_tets[k].index()] = before[remap.added_parents[k].index()];
  return after;
}

/// Which skin faces of `root` the face of a piece that lies opposite its corner f is in.
bool lies_in_skin(const Tet& piece, std::size_t f, const Tet& root, std::uint8_t skin,
                  const std::vector<Origins>& origins) {
  for (std::size_t g = 0; g < 4; ++g) {
    if ((skin >> g & 1) == 0) continue;
    const auto within = [&](VertexId v) {
      return v != root[g] && std::find(root.begin(), root.end(), v) != root.end();
    };
    bool all = true;
    for (std::size_t c = 0; c < 4 && all; ++c)
      if (c != f) all = std::all_of(origins[piece[c].index()].begin(), origins[piece[c].index()].end(), within);
    if (all) return true;
  }
  return false;
}

Vec3f to_float(const Vec3& v) {
  return v.cast<float>();
}

InstrumentSnapshot snapshot_of(const InstrumentArm& arm, double cautery) {
  InstrumentSnapshot s;
  s.kind = arm.geometry().kind;
  s.name = arm.setup().name;
  s.pose = arm.to();
  s.opening = arm.opening_to();
  s.energy = arm.input().energy;
  s.holds = arm.grasp && arm.held_before;
  s.holds_clip = arm.held_clip >= 0;
  s.force = arm.force.norm();
  s.cautery = cautery;
  return s;
}

}  // namespace

SkinFaces::SkinFaces(const TetMesh& mesh, std::span<const ContactTriangle> boundary)
    : tets_(mesh.tets), faces_(mesh.tet_count(), 0) {
  for (const ContactTriangle& t : boundary)
    faces_[t.tet.index()] = static_cast<std::uint8_t>(faces_[t.tet.index()] | 1u << t.face);
}

void SkinFaces::follow(std::span<const StiffnessChange> changes, const TetMesh& mesh) {
  if (changes.empty()) return;
  std::vector<TetId> roots(tets_.size());
  for (std::size_t t = 0; t < roots.size(); ++t) roots[t] = TetId(t);
  std::vector<Origins> origins(changes.front().remap.vertex_to_new.size());
  for (std::size_t v = 0; v < origins.size(); ++v) origins[v] = {VertexId(v)};
  std::vector<std::uint8_t> whole(tets_.size(), 1);  // not a piece of its root: corner for corner the same
  for (const StiffnessChange& change : changes) {
    origins = origins_after(change.remap, origins);
    roots = roots_after(change.remap, roots);
    std::vector<std::uint8_t> after(change.remap.tet_to_old.size(), 0);
    for (std::size_t t = 0; t < after.size(); ++t)
      if (change.remap.tet_to_old[t].valid()) after[t] = whole[change.remap.tet_to_old[t].index()];
    whole = std::move(after);
  }
  std::vector<std::uint8_t> faces(mesh.tet_count(), 0);
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const std::uint8_t skin = faces_[roots[t].index()];
    if (whole[t] != 0 || skin == 0) {
      faces[t] = skin;
      continue;
    }
    for (std::size_t f = 0; f < 4; ++f)
      if (lies_in_skin(mesh.tets[t], f, tets_[roots[t].index()], skin, origins))
        faces[t] = static_cast<std::uint8_t>(faces[t] | 1u << f);
  }
  faces_ = std::move(faces);
  tets_ = mesh.tets;
}

SnapshotMaker::SnapshotMaker(const World& world) : faces_(world.model().mesh(), world.surface().triangles()) {
  build_skin(world);
}

void SnapshotMaker::follow(const World& world) {
  kept_.insert(kept_.end(), world.events().begin(), world.events().end());
  const double supplied = world.heat().ledger().supplied;
  cautery_ = (supplied - heat_before_) / world.model().dynamics().time_step;
  heat_before_ = supplied;
  if (world.changes().empty()) return;
  faces_.follow(world.changes(), world.model().mesh());
  build_skin(world);
}

void SnapshotMaker::forget_events(std::uint64_t before) {
  const std::uint64_t gone = std::min<std::uint64_t>(kept_.size(), before - std::min(before, first_kept_));
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(gone));
  first_kept_ += gone;
}

void SnapshotMaker::build_skin(const World& world) {
  const TetMesh& mesh = world.model().mesh();
  std::map<std::int32_t, TissueLook> looks;
  for (const auto& [region, properties] : world.properties()) {
    const auto name = mesh.region_names.find(region);
    looks[region] = name == mesh.region_names.end() ? TissueLook::soft : look_of(name->second);
  }
  ++skin_.version;
  skin_.vertices.clear();
  skin_.triangles.clear();
  first_.assign(mesh.vertex_count(), none);
  next_.clear();
  triangle_of_face_.assign(4 * mesh.tet_count(), none);
  const auto corner = [&](VertexId v, TissueLook look, bool cut) {
    std::uint32_t at = first_[v.index()];
    for (; at != none; at = next_[at])
      if (skin_.vertices[at].look == look && skin_.vertices[at].cut == cut) return at;
    at = static_cast<std::uint32_t>(skin_.vertices.size());
    skin_.vertices.push_back({v.value, to_float(mesh.position(v)), look, cut});
    next_.push_back(first_[v.index()]);
    first_[v.index()] = at;
    return at;
  };
  for (const ContactTriangle& t : world.surface().triangles()) {
    const bool cut = !faces_.is_skin(t.tet, t.face);
    const TissueLook look = looks[t.region];
    triangle_of_face_[4 * t.tet.index() + t.face] = static_cast<std::uint32_t>(skin_.triangles.size());
    Triangle triangle{};
    for (std::size_t c = 0; c < 3; ++c) triangle[c] = corner(t.vertices[c], look, cut);
    skin_.triangles.push_back(triangle);
  }
}

void SnapshotMaker::fill_tissue(const World& world, Snapshot& out) const {
  if (out.skin.version != skin_.version) out.skin = skin_;
  const std::size_t n = skin_.vertices.size();
  out.positions.resize(n);
  out.conditions.resize(n);
  const std::span<const double> coagulated = world.heat().coagulation(), charred = world.heat().charring();
  const std::span<const double> blanched = world.injury().blanching(), bruised = world.injury().bruising();
  const auto value = [](std::span<const double> field, std::size_t v) {
    return field.empty() ? 0.0F : static_cast<float>(field[v]);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t v = skin_.vertices[i].vertex;
    out.positions[i] = to_float(world.state().positions[v]);
    out.conditions[i] = {value(coagulated, v), value(charred, v), value(blanched, v), value(bruised, v)};
  }
}

/// The skin's triangle at a place: the face that it names, or another bare one of its tet.
Triangle SnapshotMaker::skin_triangle(const SurfacePoint& place, const TetMesh& mesh) const {
  Triangle found{};
  if (!place.tet.valid() || place.tet.index() >= mesh.tet_count()) return found;
  const Tet& corners = mesh.tet(place.tet);
  for (std::size_t f = 0; f < 4; ++f) {
    const std::uint32_t triangle = triangle_of_face_[4 * place.tet.index() + f];
    if (triangle == none) continue;
    found = skin_.triangles[triangle];
    if (std::find(place.vertices.begin(), place.vertices.end(), corners[f]) == place.vertices.end()) break;
  }
  return found;
}

void SnapshotMaker::fill(const World& world, std::uint64_t first_event, Snapshot& out) {
  out.step = world.report().step;
  out.time = world.time();
  out.time_step = world.model().dynamics().time_step;
  out.gravity = to_float(world.options().gravity);
  fill_tissue(world, out);
  out.instruments.clear();
  const auto cauterises = [](const InstrumentArm& arm) {
    return arm.geometry().kind == InstrumentKind::hook && arm.input().energy;
  };
  const auto hooks = std::count_if(world.instruments().begin(), world.instruments().end(), cauterises);
  for (const InstrumentArm& arm : world.instruments())
    out.instruments.push_back(snapshot_of(arm, cauterises(arm) ? cautery_ / static_cast<double>(hooks) : 0));
  out.clips.clear();
  for (const Clip& clip : world.clips()) out.clips.push_back({clip.frame(), clip.shape(), clip.state()});
  out.fluids.clear();
  for (const FluidSource& source : world.fluids().sources()) {
    FluidSnapshot fluid{source.id,   source.fluid, to_float(source.position), {}, source.rate,
                        source.shed, source.pooled};
    if (!source.ended) fluid.triangle = skin_triangle(source.place, world.model().mesh());
    out.fluids.push_back(fluid);
  }
  first_event = std::max(first_event, first_kept_);
  out.first_event = first_event;
  out.events.assign(kept_.begin() + static_cast<std::ptrdiff_t>(first_event - first_kept_), kept_.end());
  out.blood_lost = world.fluids().totals().blood_lost;
  out.bile_spilled = world.fluids().totals().bile_spilled;
}

void SnapshotFeed::publish(const World& world) {
  maker_.follow(world);
  hand_over(world);
}

void SnapshotFeed::hand_over(const World& world) {
  const std::uint64_t fetched = events_fetched_.load(std::memory_order_acquire);
  maker_.forget_events(fetched);
  maker_.fill(world, fetched, slots_.writing().snapshot);
  slots_.publish();
}

const Snapshot* SnapshotFeed::fetch() {
  if (!slots_.fetch()) return nullptr;
  Snapshot& snapshot = slots_.reading().snapshot;
  // What the writer didn't know was seen by the time it filled this one.
  const std::uint64_t seen = events_fetched_.load(std::memory_order_relaxed);
  const std::uint64_t twice = seen - std::min(seen, snapshot.first_event);
  snapshot.events.erase(snapshot.events.begin(), snapshot.events.begin() + static_cast<std::ptrdiff_t>(twice));
  snapshot.first_event += twice;
  events_fetched_.store(snapshot.first_event + snapshot.events.size(), std::memory_order_release);
  current_ = &snapshot;
  return current_;
}

}  // namespace calot
