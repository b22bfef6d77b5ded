#include "calot/cut/split_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calot/cut/tet_angles.h"
#include "calot/mesh/tet_faces.h"

namespace calot::detail {
namespace {

// A vertex slides at most this far along an edge, as a share of its length.
constexpr double longest_slide = 0.5;
// A vertex counts as on the blade only if it is nearer than this share of its shortest edge: flat tets would be left.
constexpr double taken_share = 0.3;
// A vertex of the cut that an earlier sweep of the stroke left counts as on the blade up to this share of its edges.
constexpr double carried_share = 0.4;
// What a slide may change of the volume around the vertex, and of the smallest region: four tets' corners share a tet,
// so that all slides together stay below 0.1 %.
constexpr double outline_change = 2.5e-4, outline_change_of_region = 3e-6;
// For the few vertices of tets that end below the wanted angle it may be so many times more.
constexpr double generous_outline = 8;
// Pieces with smaller angles than this are worked on [°].
constexpr double good_angle = 9;
constexpr int rounds = 6;
// Tets for which whole neighbourhoods are tried: this is what costs time, and hardly ever needed.
constexpr std::uint32_t most_rearranged = 8;
// A tet with all corners on the blade belongs to neither side: worth avoiding, but no error.
constexpr double flat_on_blade = 50;
constexpr double price_of_a_piece = 0.02;
constexpr double impossible = 1e9;

/// A face at the vertex in question, by its other two vertices.
struct Spoke {
  std::uint32_t low, high;
  std::int32_t region;
  friend auto operator<=>(const Spoke&, const Spoke&) = default;
};

double price_of_angle(double angle) {
  const double x = 6 / std::max(angle, 0.05);
  return x * x * x * x;
}

}  // namespace

SplitPlan::SplitPlan(const SplitPatch& patch)
    : patch_(patch),
      meeting_(patch.vertex.size(), Meeting::off),
      along_(patch.vertex.size(), SplitPatch::none),
      rest_(patch.rest),
      now_(patch.now),
      share_(patch.edges.size()),
      edge_rest_(patch.edges.size()),
      edge_now_(patch.edges.size()),
      priority_(patch.edges.size()),
      choices_(patch.vertex.size()),
      outline_(patch.vertex.size()) {
  for (std::uint32_t e = 0; e < patch.edges.size(); ++e) {
    set_share(e, patch.edges[e].share);
    priority_[e] = (patch.rest[patch.edges[e].a] - patch.rest[patch.edges[e].b]).norm();
    highest_ = std::max(highest_, priority_[e]);
  }
  find_given();
  find_outlines();
}

/// Vertices in the plane, and those of the cut so far that the blade comes by.
void SplitPlan::find_given() {
  for (std::uint32_t v = 0; v < patch_.vertex.size(); ++v) {
    if (patch_.side[v] == 0) meeting_[v] = Meeting::given;
    if ((patch_.front[v] == 0 && patch_.lip[v] == 0) || patch_.edges_of_vertex[v].empty()) continue;
    double sum = 0;
    for (const std::uint32_t t : patch_.star[v])
      for (const std::uint32_t w : patch_.corners[t]) sum += (patch_.now[v] - patch_.now[w]).norm();
    const double edge = sum / (3 * static_cast<double>(patch_.star[v].size()));
    if (std::abs(patch_.height[v]) <= carried_share * edge) meeting_[v] = Meeting::given;
  }
}

/// The faces at each crossed edge's ends that one tet only has, or that lie between regions.
void SplitPlan::find_outlines() {
  std::vector<Spoke> spokes;
  for (std::uint32_t v = 0; v < patch_.core; ++v) {
    if (patch_.edges_of_vertex[v].empty()) continue;
    spokes.clear();
    for (const std::uint32_t t : patch_.star[v]) {
      std::array<std::uint32_t, 3> others{};
      std::size_t count = 0;
      for (const std::uint32_t w : patch_.corners[t])
        if (w != v) others[count++] = w;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax(others[i], others[(i + 1) % 3]);
        spokes.push_back({low, high, patch_.region[t]});
      }
    }
    std::sort(spokes.begin(), spokes.end());
    for (std::size_t i = 0; i < spokes.size(); ++i) {
      const bool paired =
          i + 1 < spokes.size() && spokes[i].low == spokes[i + 1].low && spokes[i].high == spokes[i + 1].high;
      if (!paired || spokes[i].region != spokes[i + 1].region) outline_[v].push_back({spokes[i].low, spokes[i].high});
      if (paired) ++i;
    }
  }
}

/// @param generous  where nothing else helps: up to the whole flatness asked for, and more of the outline's volume
void SplitPlan::list_choices(std::uint32_t v, bool generous) {
  choices_[v].assign(1, {});
  double shortest = std::numeric_limits<double>::infinity();
  for (const std::uint32_t t : patch_.star[v])
    for (const std::uint32_t w : patch_.corners[t])
      if (w != v) shortest = std::min(shortest, (patch_.now[v] - patch_.now[w]).norm());
  const double height = std::abs(patch_.height[v]);
  if (height <= (generous ? patch_.most_flatness : patch_.flatness) && height <= taken_share * shortest)
    choices_[v].push_back({Meeting::taken});
  if (patch_.fixed[v] != 0) return;
  for (const std::uint32_t e : patch_.edges_of_vertex[v]) {
    const CrossedEdge& edge = patch_.edges[e];
    const double share = edge.a == v ? edge.share : 1 - edge.share;
    if (share > longest_slide) continue;
    const Vec3 place = patch_.rest[edge.a] + edge.share * (patch_.rest[edge.b] - patch_.rest[edge.a]);
    if (keeps_outline(v, place, generous ? generous_outline : 1)) choices_[v].push_back({Meeting::slid, e});
  }
}

bool SplitPlan::keeps_outline(std::uint32_t v, const Vec3& place, double slack) const {
  if (outline_[v].empty()) return true;
  double change = 0, around = 0;
  for (const auto& [x, y] : outline_[v])
    change += std::abs(signed_volume(patch_.rest[v], patch_.rest[x], patch_.rest[y], place));
  for (const std::uint32_t t : patch_.star[v]) {
    const auto& c = patch_.corners[t];
    around += signed_volume(patch_.rest[c[0]], patch_.rest[c[1]], patch_.rest[c[2]], patch_.rest[c[3]]);
  }
  return change <= slack * std::max(outline_change * around, outline_change_of_region * patch_.smallest_region);
}

void SplitPlan::set(std::uint32_t v, const Choice& choice) {
  meeting_[v] = choice.meeting;
  along_[v] = choice.along;
  if (choice.meeting == Meeting::slid) {
    const CrossedEdge& edge = patch_.edges[choice.along];
    rest_[v] = patch_.rest[edge.a] + edge.share * (patch_.rest[edge.b] - patch_.rest[edge.a]);
    now_[v] = patch_.now[edge.a] + edge.share * (patch_.now[edge.b] - patch_.now[edge.a]);
  } else {
    rest_[v] = patch_.rest[v];
    now_[v] = patch_.now[v];
  }
}

void SplitPlan::set_share(std::uint32_t e, double share) {
  const CrossedEdge& edge = patch_.edges[e];
  share_[e] = share;
  edge_rest_[e] = patch_.rest[edge.a] + share * (patch_.rest[edge.b] - patch_.rest[edge.a]);
  edge_now_[e] = patch_.now[edge.a] + share * (patch_.now[edge.b] - patch_.now[edge.a]);
}

void SplitPlan::pieces_of(std::uint32_t tet, Pieces& pieces) const {
  pieces.assign(1, patch_.corners[tet]);
  std::array<std::uint32_t, 6> order{};
  std::size_t count = 0;
  const auto before = [&](std::uint32_t x, std::uint32_t y) {
    return priority_[x] != priority_[y] ? priority_[x] > priority_[y] : x < y;
  };
  for (const std::uint32_t e : patch_.edges_of_tet[tet]) {
    if (e == SplitPatch::none || !bisected(e)) continue;
    std::size_t place = count++;
    for (; place > 0 && before(e, order[place - 1]); --place) order[place] = order[place - 1];
    order[place] = e;
  }
  for (std::size_t k = 0; k < count; ++k) {
    const CrossedEdge& edge = patch_.edges[order[k]];
    const auto middle = static_cast<std::uint32_t>(patch_.vertex.size() + order[k]);
    for (std::size_t p = 0, size = pieces.size(); p < size; ++p) {
      auto piece = pieces[p];
      const auto a = std::find(piece.begin(), piece.end(), edge.a), b = std::find(piece.begin(), piece.end(), edge.b);
      if (a == piece.end() || b == piece.end()) continue;
      *b = middle;
      pieces[p] = piece;
      *b = edge.b;
      *a = middle;
      pieces.push_back(piece);
    }
  }
}

double SplitPlan::smallest_angle(std::uint32_t tet) const {
  pieces_of(tet, scratch_);
  double angle = 180;
  for (const auto& p : scratch_)
    angle = std::min(angle, smallest_dihedral(rest(p[0]), rest(p[1]), rest(p[2]), rest(p[3])));
  return angle;
}

double SplitPlan::price(std::uint32_t tet) const {
  const auto& c = patch_.corners[tet];
  const double angle = smallest_angle(tet);
  double price = price_of_angle(angle) + price_of_a_piece * static_cast<double>(scratch_.size());
  if (!(angle > 0)) price += impossible;
  if (on(c[0]) && on(c[1]) && on(c[2]) && on(c[3])) price += flat_on_blade;
  if (patch_.deformed) {
    // Pieces keep the tet's shape; only slides can turn it inside out where it is now.
    const auto volume = [&](const std::vector<Vec3>& x) { return signed_volume(x[c[0]], x[c[1]], x[c[2]], x[c[3]]); };
    const double before = volume(patch_.now);
    if (before > 0 && volume(now_) < 0.05 * before) price += impossible;
  }
  return price;
}

template <class Tets>
double SplitPlan::price_of(const Tets& tets) const {
  double sum = 0;
  for (const std::uint32_t t : tets) sum += price(t);
  return sum;
}

/// Takes the best of a vertex's choices; whether that lowers the price.
bool SplitPlan::choose(std::uint32_t v) {
  if (choices_[v].size() < 2) return false;
  const Choice before{meeting_[v], along_[v]};
  Choice best = before;
  double least = price_of(patch_.star[v]) - 1e-9;
  for (const Choice& choice : choices_[v]) {
    if (choice.meeting == before.meeting && choice.along == before.along) continue;
    set(v, choice);
    if (const double p = price_of(patch_.star[v]); p < least) {
      least = p - 1e-9;
      best = choice;
    }
  }
  set(v, best);
  return best.meeting != before.meeting || best.along != before.along;
}

bool SplitPlan::reorder(std::uint32_t e) {
  const double before = price_of(patch_.ring[e]), old = priority_[e];
  for (const double p : {highest_ + 1, lowest_ - 1}) {
    priority_[e] = p;
    if (price_of(patch_.ring[e]) >= before - 1e-9) continue;
    highest_ = std::max(highest_, p);
    lowest_ = std::min(lowest_, p);
    return true;
  }
  priority_[e] = old;
  return false;
}

/// Moves the point on an edge off the plane, within the flatness allowed.
bool SplitPlan::shift(std::uint32_t e) {
  const CrossedEdge& edge = patch_.edges[e];
  const double reach = patch_.flatness / std::abs(patch_.height[edge.a] - patch_.height[edge.b]);
  const double old = share_[e];
  double best = old, least = price_of(patch_.ring[e]) - 1e-9;
  for (const double step : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const double share = edge.share + step * reach;
    if (share == old || share < 0.02 || share > 0.98) continue;
    set_share(e, share);
    if (const double p = price_of(patch_.ring[e]); p < least) {
      least = p - 1e-9;
      best = share;
    }
  }
  set_share(e, best);
  return best != old;
}

bool SplitPlan::mend(std::uint32_t tet) {
  bool better = false;
  for (const std::uint32_t v : patch_.corners[tet]) better = choose(v) || better;
  for (const std::uint32_t e : patch_.edges_of_tet[tet])
    if (e != SplitPatch::none && bisected(e)) better = reorder(e) || better;
  for (const std::uint32_t e : patch_.edges_of_tet[tet])
    if (e != SplitPatch::none && bisected(e)) better = shift(e) || better;
  return better;
}

/// The tets that share a vertex with this one.
std::vector<std::uint32_t> SplitPlan::tets_about(std::uint32_t tet) const {
  std::vector<std::uint32_t> tets;
  for (const std::uint32_t v : patch_.corners[tet])
    if (v < patch_.core) tets.insert(tets.end(), patch_.star[v].begin(), patch_.star[v].end());
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  return tets;
}

/// Lets every choice at these tets find its best place among the others.
void SplitPlan::settle(const std::vector<std::uint32_t>& tets) {
  for (int round = 0; round < 2; ++round)
    for (const std::uint32_t t : tets)
      if (smallest_angle(t) < good_angle) mend(t);
}

/// Forces one choice at the tet, lets those around it settle, and keeps the whole if that is better.
bool SplitPlan::rearrange(std::uint32_t tet) {
  std::vector<std::uint32_t> tets;
  for (const std::uint32_t t : tets_about(tet))
    for (const std::uint32_t u : tets_about(t)) tets.push_back(u);
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  const std::vector<std::uint32_t> about = tets_about(tet);
  for (const std::uint32_t v : patch_.corners[tet]) {
    const std::vector<Choice> all = choices_[v];
    for (const Choice& choice : all) {
      if (choice.meeting == meeting_[v] && choice.along == along_[v]) continue;
      const SplitPlan before = *this;
      const double least = price_of(tets) - 1e-6;
      set(v, choice);
      choices_[v].clear();  // so that it stays as forced
      settle(about);
      choices_[v] = all;
      if (price_of(tets) < least) return true;
      restore(before);
    }
  }
  return false;
}

void SplitPlan::restore(const SplitPlan& before) {
  meeting_ = before.meeting_;
  along_ = before.along_;
  rest_ = before.rest_;
  now_ = before.now_;
  share_ = before.share_;
  edge_rest_ = before.edge_rest_;
  edge_now_ = before.edge_now_;
  priority_ = before.priority_;
  highest_ = before.highest_;
  lowest_ = before.lowest_;
}

void SplitPlan::search(double wanted) {
  std::vector<std::pair<double, std::uint32_t>> order;  // nearest crossing first
  for (std::uint32_t v = 0; v < patch_.core; ++v) {
    if (patch_.edges_of_vertex[v].empty() || on(v)) continue;
    list_choices(v, false);
    double nearest = 1;
    for (const std::uint32_t e : patch_.edges_of_vertex[v])
      nearest = std::min(nearest, patch_.edges[e].a == v ? patch_.edges[e].share : 1 - patch_.edges[e].share);
    order.emplace_back(nearest, v);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [nearest, v] : order) choose(v);
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::pair<double, std::uint32_t>> bad;
    for (std::uint32_t t = 0; t < patch_.tet.size(); ++t)
      if (const double angle = smallest_angle(t); angle < good_angle) bad.emplace_back(angle, t);
    std::sort(bad.begin(), bad.end());
    bool better = false;
    for (const auto& [angle, t] : bad) better = mend(t) || better;
    if (!better) break;
  }
  for (std::uint32_t t = 0, tries = 0; t < patch_.tet.size() && tries < most_rearranged; ++t) {
    if (smallest_angle(t) >= 1.1 * wanted) continue;
    ++tries;
    for (const std::uint32_t v : patch_.corners[t])
      if (v < patch_.core && meeting_[v] != Meeting::given && !patch_.edges_of_vertex[v].empty()) list_choices(v, true);
    if (mend(t) && smallest_angle(t) >= 1.1 * wanted) continue;
    rearrange(t);
  }
}

}  // namespace calot::detail
