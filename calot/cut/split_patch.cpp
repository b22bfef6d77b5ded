#include "calot/cut/split_patch.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "calot/mesh/tet_faces.h"

namespace calot::detail {
namespace {

// Closer to the plane than this share of `flatness`, a vertex lies in it: rounding must not decide.
constexpr double rounding_share = 1e-3;
// The cut lies off the plane by at most this share of the mean edge: a fine mesh can follow the blade.
constexpr double flatness_share = 0.1;

std::vector<std::uint8_t> tets_in_region(const TetMesh& mesh, const std::string& region) {
  if (region == "*") return std::vector<std::uint8_t>(mesh.tet_count(), 1);
  const std::vector<std::int32_t> regions = regions_matching(mesh, region, "region");
  std::vector<std::uint8_t> allowed(mesh.tet_count());
  for (std::size_t t = 0; t < allowed.size(); ++t)
    allowed[t] = std::find(regions.begin(), regions.end(), mesh.regions[t]) != regions.end() ? 1 : 0;
  return allowed;
}

/// Tets whose corners lie on both sides of the plane, or near it, where the blade may have passed.
std::vector<TetId> tets_near(const TetMesh& mesh, std::span<const Vec3> current, const SweptPlane& blade,
                             double reach) {
  std::vector<Vec3> flat(current.size());  // in the plane's coordinates, height last
  for (std::size_t v = 0; v < flat.size(); ++v) flat[v] << blade.flat(current[v]), blade.height(current[v]);
  std::vector<TetId> near;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    Vec3 low = flat[tet[0].index()], high = low;
    for (std::size_t c = 1; c < 4; ++c) {
      low = low.cwiseMin(flat[tet[c].index()]);
      high = high.cwiseMax(flat[tet[c].index()]);
    }
    if (low.z() > reach || high.z() < -reach) continue;
    if (blade.may_cover(low.head<2>(), high.head<2>())) near.emplace_back(t);
  }
  return near;
}

double smallest_region_volume(const TetMesh& mesh) {
  std::map<std::int32_t, double> volumes;
  double* volume = nullptr;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    if (t == 0 || mesh.regions[t] != mesh.regions[t - 1]) volume = &volumes[mesh.regions[t]];
    *volume += signed_volume(mesh, TetId(t));
  }
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& [region, size] : volumes) smallest = std::min(smallest, size);
  return smallest;
}

template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

Rows rows_of(std::size_t count, std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs) {
  std::sort(pairs.begin(), pairs.end());
  Rows rows;
  rows.start.assign(count + 1, 0);
  for (const auto& [row, item] : pairs) {
    ++rows.start[row + 1];
    rows.items.push_back(item);
  }
  std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
  return rows;
}

class Gatherer {
 public:
  Gatherer(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current, const SweptPlane& blade,
           const SplitOptions& options)
      : mesh_(mesh), around_(around), current_(current), blade_(blade), options_(options) {}

  SplitPatch run() {
    const std::vector<TetId> near = tets_near(mesh_, current_, blade_, options_.flatness);
    if (near.empty()) return {};
    const std::vector<std::uint8_t> allowed = tets_in_region(mesh_, options_.region);
    if (std::none_of(near.begin(), near.end(), [&](TetId t) { return allowed[t.index()] != 0; })) return {};
    add_vertices(near);
    add_tets(allowed);
    add_edges();
    patch_.smallest_region = smallest_region_volume(mesh_);
    set_flatness();
    return std::move(patch_);
  }

 private:
  [[nodiscard]] bool at_front(VertexId v) const {
    return options_.stroke != nullptr &&
           std::binary_search(options_.stroke->front.begin(), options_.stroke->front.end(), v);
  }
  [[nodiscard]] bool on_lip(VertexId v) const {
    return options_.stroke != nullptr &&
           std::binary_search(options_.stroke->lips.begin(), options_.stroke->lips.end(), v);
  }
  [[nodiscard]] std::span<const TetId> tets_around(VertexId v) const {
    return {around_.tets.data() + around_.start[v.index()], around_.start[v.index() + 1] - around_.start[v.index()]};
  }

  /// The core: corners of the tets near the blade, and vertices of the cut beside them. Then all their tets' corners.
  void add_vertices(const std::vector<TetId>& near) {
    std::vector<VertexId> core, rim;
    for (const TetId t : near) core.insert(core.end(), mesh_.tet(t).begin(), mesh_.tet(t).end());
    sort_unique(core);
    if (options_.stroke != nullptr && !options_.stroke->front.empty()) {
      for (const VertexId v : std::vector<VertexId>(core))
        for (const TetId t : tets_around(v))
          for (const VertexId w : mesh_.tet(t))
            if (at_front(w)) core.push_back(w);
      sort_unique(core);
    }
    for (const VertexId v : core)
      for (const TetId t : tets_around(v)) patch_.tet.push_back(t);
    sort_unique(patch_.tet);
    number_.assign(mesh_.vertex_count(), SplitPatch::none);
    for (const VertexId v : core) add_vertex(v);
    patch_.core = core.size();
    for (const TetId t : patch_.tet)
      for (const VertexId v : mesh_.tet(t))
        if (number_[v.index()] == SplitPatch::none) add_vertex(v);
  }

  void add_vertex(VertexId v) {
    number_[v.index()] = static_cast<std::uint32_t>(patch_.vertex.size());
    const Vec3& now = current_[v.index()];
    const double height = blade_.height(now);
    patch_.vertex.push_back(v);
    patch_.rest.push_back(mesh_.position(v));
    patch_.now.push_back(now);
    patch_.deformed = patch_.deformed || now != mesh_.position(v);
    patch_.height.push_back(height);
    const bool in_plane = std::abs(height) <= rounding_share * options_.flatness;
    patch_.side.push_back(static_cast<std::int8_t>(in_plane ? 0 : blade_.side(now)));
    patch_.front.push_back(at_front(v) ? 1 : 0);
    patch_.lip.push_back(on_lip(v) ? 1 : 0);
    patch_.fixed.push_back(options_.fixed.empty() ? 0 : options_.fixed[v.index()]);
  }

  void add_tets(const std::vector<std::uint8_t>& allowed) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> star;
    for (std::uint32_t t = 0; t < patch_.tet.size(); ++t) {
      const std::size_t old = patch_.tet[t].index();
      std::array<std::uint32_t, 4> corners;
      for (std::size_t c = 0; c < 4; ++c) {
        corners[c] = number_[mesh_.tets[old][c].index()];
        star.emplace_back(corners[c], t);
      }
      patch_.corners.push_back(corners);
      patch_.region.push_back(mesh_.regions[old]);
      patch_.allowed.push_back(allowed[old]);
    }
    patch_.star = rows_of(patch_.vertex.size(), std::move(star));
  }

  void add_edges() {
    using Pair = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Pair> wanted;
    const auto crossed = [&](std::uint32_t a, std::uint32_t b) { return patch_.side[a] * patch_.side[b] < 0; };
    for (std::size_t t = 0; t < patch_.tet.size(); ++t) {
      if (patch_.allowed[t] == 0) continue;
      for (const auto& [i, j] : edge_corners)
        if (const Pair edge = std::minmax(patch_.corners[t][i], patch_.corners[t][j]); crossed(edge.first, edge.second))
          wanted.push_back(edge);
    }
    sort_unique(wanted);
    std::vector<Pair> kept, of_vertex, ring;
    for (const auto& [a, b] : wanted) {
      const double share = patch_.height[a] / (patch_.height[a] - patch_.height[b]);
      if (!blade_.covers(patch_.now[a] + share * (patch_.now[b] - patch_.now[a]))) continue;
      of_vertex.emplace_back(a, patch_.edges.size());
      of_vertex.emplace_back(b, patch_.edges.size());
      patch_.edges.push_back({a, b, share});
      kept.emplace_back(a, b);
    }
    patch_.edges_of_tet.assign(patch_.tet.size(), {SplitPatch::none, SplitPatch::none, SplitPatch::none,
                                                   SplitPatch::none, SplitPatch::none, SplitPatch::none});
    for (std::uint32_t t = 0; t < patch_.tet.size(); ++t)
      for (std::size_t e = 0; e < 6; ++e) {
        const Pair edge = std::minmax(patch_.corners[t][edge_corners[e][0]], patch_.corners[t][edge_corners[e][1]]);
        if (!crossed(edge.first, edge.second)) continue;
        const auto found = std::lower_bound(kept.begin(), kept.end(), edge);
        if (found == kept.end() || *found != edge) continue;
        patch_.edges_of_tet[t][e] = static_cast<std::uint32_t>(found - kept.begin());
        ring.emplace_back(patch_.edges_of_tet[t][e], t);
      }
    patch_.ring = rows_of(patch_.edges.size(), std::move(ring));
    patch_.edges_of_vertex = rows_of(patch_.vertex.size(), std::move(of_vertex));
  }

  void set_flatness() {
    double sum = 0;
    for (const auto& c : patch_.corners)
      for (const auto& [i, j] : edge_corners) sum += (patch_.now[c[i]] - patch_.now[c[j]]).norm();
    const double edge = sum / (6 * static_cast<double>(patch_.corners.size()));
    patch_.most_flatness = options_.flatness;
    patch_.flatness = std::min(options_.flatness, flatness_share * edge);
  }

  const TetMesh& mesh_;
  const VertexTets& around_;
  std::span<const Vec3> current_;
  const SweptPlane& blade_;
  const SplitOptions& options_;
  std::vector<std::uint32_t> number_;  // of each vertex of the mesh in the patch
  SplitPatch patch_;
};

}  // namespace

SplitPatch gather_patch(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> current,
                        const SweptPlane& blade, const SplitOptions& options) {
  return Gatherer(mesh, around, current, blade, options).run();
}

}  // namespace calot::detail
