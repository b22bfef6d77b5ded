// Cuts, burns and tears: the one way in which a topology edit reaches every part of the world.
#include <algorithm>
#include <cstdio>
#include <numeric>

#include "calot/base/error.h"
#include "calot/cut/crossed_tets.h"
#include "calot/cut/separate.h"
#include "calot/cut/split.h"
#include "calot/sim/element_changes.h"
#include "calot/sim/world.h"

namespace calot {
namespace {

// Ligaments of tissue that is gone go with it; where their vertex is doubled they hold both copies.
std::vector<Spring> followed(const std::vector<Spring>& springs, const Remap& remap) {
  std::vector<Spring> result;
  for (Spring spring : springs) {
    std::vector<VertexId> copies;
    for (std::size_t k = 0; k < remap.added_vertices.size(); ++k)
      if (remap.added_from[k].from == spring.vertex && remap.added_from[k].to == spring.vertex)
        copies.push_back(remap.added_vertices[k]);
    spring.stiffness /= static_cast<double>(1 + copies.size());
    for (const VertexId copy : copies) {
      Spring other = spring;
      other.vertex = copy;
      if (spring.other.valid()) other.other = remap.vertex_to_new[spring.other.index()];
      if (!spring.other.valid() || other.other.valid()) result.push_back(other);
    }
    spring.vertex = remap.vertex_to_new[spring.vertex.index()];
    if (spring.other.valid()) {
      spring.other = remap.vertex_to_new[spring.other.index()];
      if (!spring.other.valid()) continue;
    }
    if (spring.vertex.valid()) result.push_back(spring);
  }
  return result;
}

std::vector<TetId> followed(const std::vector<TetId>& tets, const Remap& remap) {
  std::vector<TetId> result;
  for (const TetId t : tets)
    if (remap.tet_to_new[t.index()].valid()) result.push_back(remap.tet_to_new[t.index()]);
  return result;
}

// The same, and the pieces of those that were cut.
std::vector<TetId> followed_with_pieces(const std::vector<TetId>& tets, const Remap& remap) {
  std::vector<TetId> result = followed(tets, remap);
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
    if (std::binary_search(tets.begin(), tets.end(), remap.added_parents[k])) result.push_back(remap.added_tets[k]);
  std::sort(result.begin(), result.end());
  return result;
}

// Numbers that the mesh doesn't have: looked for before anything is read by them.
bool names_only_what_is_there(const TopologyEdit& edit, const TetMesh& mesh) {
  const std::size_t n = mesh.vertex_count(), m = mesh.tet_count(), all = n + edit.vertices.size();
  const auto vertex = [&](VertexId v) { return v.index() < n; };
  return std::all_of(edit.removed.begin(), edit.removed.end(), [&](TetId t) { return t.index() < m; }) &&
         std::is_sorted(edit.removed.begin(), edit.removed.end()) &&
         std::all_of(edit.vertices.begin(), edit.vertices.end(),
                     [&](const AddedVertex& v) { return vertex(v.from) && vertex(v.to); }) &&
         std::all_of(edit.moved.begin(), edit.moved.end(),
                     [&](const MovedVertex& v) { return vertex(v.vertex) && vertex(v.to); }) &&
         std::all_of(edit.tets.begin(), edit.tets.end(), [&](const AddedTet& t) {
           return t.parent.index() < m &&
                  std::all_of(t.vertices.begin(), t.vertices.end(), [&](VertexId v) { return v.index() < all; });
         });
}

// Flags of tets; pieces have their parent's.
std::vector<std::uint8_t> followed(const std::vector<std::uint8_t>& flags, const Remap& remap) {
  std::vector<std::uint8_t> result(remap.tet_to_old.size(), 0);
  for (std::size_t t = 0; t < result.size(); ++t)
    if (remap.tet_to_old[t].valid()) result[t] = flags[remap.tet_to_old[t].index()];
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k)
    result[remap.added_tets[k].index()] = flags[remap.added_parents[k].index()];
  return result;
}

// Of vertices: an added one has its origins', moved ones lie between vertices of one part.
std::vector<std::uint8_t> followed_vertices(const std::vector<std::uint8_t>& flags, const Remap& remap) {
  if (flags.empty()) return {};
  std::vector<std::uint8_t> result(remap.vertex_to_old.size(), 0);
  for (std::size_t v = 0; v < result.size(); ++v)
    if (remap.vertex_to_old[v].valid()) result[v] = flags[remap.vertex_to_old[v].index()];
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k)
    result[remap.added_vertices[k].index()] = flags[remap.added_from[k].from.index()];
  return result;
}

}  // namespace

const StiffnessChange* World::edit(const TopologyEdit& edit, EventKind cause, const std::string& text,
                                   std::int32_t instrument) {
  if (edit.empty()) return nullptr;
  begin_news(Stage::edited);
  return apply(edit, cause, text, instrument);
}

// The order: first what the others look at (mesh, positions), then all who keep numbers of vertices or tets.
const StiffnessChange* World::apply(const TopologyEdit& edit, EventKind cause, const std::string& text,
                                    std::int32_t instrument) {
  if (edit.empty()) return nullptr;
  if (!names_only_what_is_there(edit, model_.mesh())) {
    say(EventKind::cut_refused, instrument, 0, "the edit names vertices or tets that the mesh doesn't have");
    return nullptr;
  }
  const ChangedTets changed = changed_tets(edit, around_);
  std::vector<ElementChange> elements = leaving(model_, changed);
  StiffnessChange change;
  try {
    change = model_.apply(edit);
  } catch (const InputError& refused) {
    say(EventKind::cut_refused, instrument, 0, refused.what());
    return nullptr;
  }
  const Remap& remap = change.remap;
  add_entering(model_, remap, changed, elements);
  const std::vector<Vec3> positions_before = state_.positions;
  state_.positions = carry_over(state_.positions, remap);
  state_.velocities = carry_over(state_.velocities, remap);
  around_ = vertex_tets(model_.mesh());
  tissue_.follow(model_, remap);
  const std::size_t groups = motion_.group_count();
  motion_.follow(model_);
  came_off_ = came_off_ || motion_.group_count() > groups;
  compliance_.follow(elements, remap);
  surface_.follow(model_.mesh(), remap);
  renew_triangles();
  for (InstrumentArm& arm : arms_) {
    if (arm.grasp) arm.grasp->follow(remap, positions_before, state_.positions);
    arm.stroke = calot::follow(arm.stroke, remap);
  }
  for (Clip& clip : clips_) clip.follow(remap, positions_before, state_.positions);
  ligaments_ = followed(ligaments_, remap);
  weigh_carried();
  heat_.follow(remap, model_.mesh(), around_);
  injury_.follow(remap);
  fluids_.follow(remap, model_.mesh(), around_);
  tearing_.follow(remap, model_.mesh());
  to_vaporise_ = followed(to_vaporise_, remap);
  to_stiffen_ = followed_with_pieces(to_stiffen_, remap);
  for (auto& face : to_part_)
    for (VertexId& v : face) v = remap.vertex_to_new[v.index()];
  std::erase_if(to_part_, [](const auto& face) { return !face[0].valid() || !face[1].valid() || !face[2].valid(); });
  closed_ = followed(closed_, remap);
  lost_ = followed_vertices(lost_, remap);
  say(cause, instrument, static_cast<double>(edit.tets.size() + edit.removed.size()), text);
  changes_.push_back(std::move(change));
  return &changes_.back();
}

void World::edit_tissue() {
  try {
    part_torn();
    for (std::size_t k = 0; k < arms_.size(); ++k)
      if (arms_[k].scissors) cut_with_scissors(k);
  } catch (const InputError& refused) {
    say(EventKind::cut_refused, -1, 0, refused.what());
  }
  remove_vaporised();
  drop_debris();
  stiffen();
}

// Of the groups of tissue that hang together by tets, those that nothing holds: no bone, ligament, clip or jaw.
std::vector<std::uint8_t> World::loose_groups() const {
  const std::span<const std::uint32_t> group = motion_.groups();
  std::vector<std::uint8_t> loose(motion_.group_count(), 1);
  for (std::size_t v = 0; v < group.size(); ++v)
    if (model_.is_fixed(VertexId(v))) loose[group[v]] = 0;
  for (const Spring& spring : ligaments_) {
    loose[group[spring.vertex.index()]] = 0;
    if (spring.other.valid()) loose[group[spring.other.index()]] = 0;
  }
  for (std::size_t v = 0; v < group.size(); ++v)
    if (loose[group[v]] &&
        (std::any_of(arms_.begin(), arms_.end(),
                     [&](const InstrumentArm& arm) { return arm.grasp && arm.grasp->holds(VertexId(v)); }) ||
         std::any_of(clips_.begin(), clips_.end(), [&](const Clip& clip) { return clip.holds(VertexId(v)); })))
      loose[group[v]] = 0;
  return loose;
}

// Scraps that blades and tears leave: too light for their stiffness to be moved in steps of a frame, and no one's
// interest.
void World::drop_debris() {
  if (changes_.empty() || !(options_.debris > 0)) return;
  const TetMesh& mesh = model_.mesh();
  const std::span<const std::uint32_t> group = motion_.groups();
  std::vector<double> volume(motion_.group_count(), 0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    volume[group[mesh.tets[t][0].index()]] += signed_volume(mesh, TetId(t));
  if (*std::min_element(volume.begin(), volume.end()) >= options_.debris) return;
  const std::vector<std::uint8_t> loose = loose_groups();
  TopologyEdit removal;
  double sum = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const std::uint32_t g = group[mesh.tets[t][0].index()];
    if (!loose[g] || volume[g] >= options_.debris) continue;
    removal.removed.push_back(TetId(t));
    sum += signed_volume(mesh, TetId(t));
  }
  if (removal.removed.empty()) return;
  char text[96];
  std::snprintf(text, sizeof text, "scraps of %zu tets, %.3f mm³ in all, came off and are gone", removal.removed.size(),
                1e9 * sum);
  if (apply(removal, EventKind::debris, text)) events_.back().amount = 1e6 * sum;
}

void World::cut_with_scissors(std::size_t k) {
  InstrumentArm& arm = arms_[k];
  const bool closing = arm.closing();
  const Sweep sweep = arm.scissors->close(arm.from(), arm.to(), arm.opening_to());
  if (!closing) {
    arm.stroke = {};
    return;
  }
  if (sweep.triangles.empty()) return;
  const auto number = static_cast<std::int32_t>(k);
  if (options_.split) {
    SplitOptions options;
    options.stroke = &arm.stroke;
    options.fixed = model_.fixed();
    SplitEdit cut = calot::split(model_.mesh(), around_, state_.positions, sweep, options);
    if (cut.empty()) {
      arm.stroke = cut.report.stroke;  // vertices may lie on the blade as they are
      return;
    }
    // The stroke's new numbers count from the edit's: `edit` follows them like all others, so it is set apart.
    const Stroke next = cut.report.stroke;
    const StiffnessChange* change = apply(cut, EventKind::cut,
                                          arm.setup().name + " cut " + std::to_string(cut.report.crossed) +
                                              " edges, opened " + std::to_string(cut.report.separated) + " faces",
                                          number);
    arm.in_cut = arm.in_cut || (change && cut.report.separated > 0);
    arm.stroke = change ? calot::follow(next, change->remap) : Stroke{};
    return;
  }
  TopologyEdit removal;
  removal.removed = crossed_tets(model_.mesh(), state_.positions, sweep);
  arm.in_cut = arm.in_cut || !removal.empty();
  apply(removal, EventKind::cut,
        arm.setup().name + " removed " + std::to_string(removal.removed.size()) + " tets that its blades crossed",
        number);
}

void World::part_torn() {
  if (to_part_.empty()) return;
  const TopologyEdit tear = separate(model_.mesh(), around_, to_part_);
  to_part_.clear();
  apply(tear, EventKind::torn, "tissue tore where it was stretched beyond what it bears");
}

void World::remove_vaporised() {
  if (to_vaporise_.empty()) return;
  TopologyEdit burn;
  burn.removed = to_vaporise_;
  to_vaporise_.clear();
  apply(burn, EventKind::burnt, "heat vaporised " + std::to_string(burn.removed.size()) + " tets");
}

void World::stiffen() {
  if (to_stiffen_.empty()) return;
  std::vector<double> factors;
  for (const TetId t : to_stiffen_) factors.push_back(heat_.stiffness_factor(t));
  const ChangedTets changed{{}, to_stiffen_};
  std::vector<ElementChange> elements = leaving(model_, changed);
  StiffnessChange change = model_.scale_stiffness(to_stiffen_, factors);
  add_entering(model_, change.remap, changed, elements);
  tissue_.restiffen(model_);
  motion_.follow(model_);
  compliance_.follow(elements, change.remap);
  changes_.push_back(std::move(change));
  to_stiffen_.clear();
}

}  // namespace calot
