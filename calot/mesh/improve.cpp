#include "calot/mesh/improve.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "calot/mesh/tet_faces.h"

namespace calot {
namespace {

constexpr double nothing = -std::numeric_limits<double>::infinity();

/// How a vertex may move.
struct Freedom {
  bool boundary = false;       // on a boundary between regions, or outside
  Vec3 normal = Vec3::Zero();  // of the boundary; zero where boundaries meet
  Vec3 home = Vec3::Zero();    // where it was at first
  double edge = 0;             // mean length of its edges at first
};

class Improver {
 public:
  Improver(TetMesh& mesh, const ImproveOptions& options) : mesh_(mesh), options_(options) {
    around_.resize(mesh.vertex_count());
    for (std::size_t t = 0; t < mesh.tet_count(); ++t) hang_in(static_cast<std::uint32_t>(t));
    alive_.assign(mesh.tet_count(), 1);
    find_freedom();
  }
  Improvement run();

 private:
  [[nodiscard]] double quality_of(const Tet& tet) const;
  [[nodiscard]] double worst(const std::vector<std::uint32_t>& tets) const;
  [[nodiscard]] std::vector<std::uint32_t> bad_tets() const;
  void find_freedom();
  void hang_in(std::uint32_t t) {
    for (const VertexId v : mesh_.tets[t]) around_[v.index()].push_back(t);
  }
  void take_out(std::uint32_t t);
  void replace(const std::vector<std::uint32_t>& old, const std::vector<Tet>& fresh);
  [[nodiscard]] bool allowed(VertexId v, const Vec3& place) const;
  bool move(VertexId v);
  bool remove_edge(VertexId a, VertexId b);
  bool remove_face(std::uint32_t t, std::size_t corner);
  bool collapse(VertexId gone, VertexId onto);
  [[nodiscard]] std::vector<std::uint32_t> tets_of_edge(VertexId a, VertexId b) const;
  [[nodiscard]] std::vector<VertexId> ring_of(VertexId a, VertexId b, const std::vector<std::uint32_t>& tets) const;
  [[nodiscard]] std::vector<Tet> best_filling(VertexId a, VertexId b, const std::vector<VertexId>& ring,
                                              double better_than) const;
  bool mend(std::uint32_t t);
  void compact();

  TetMesh& mesh_;
  const ImproveOptions options_;
  std::vector<std::vector<std::uint32_t>> around_;  // tets of each vertex, in order of arrival
  std::vector<std::uint8_t> alive_;
  std::vector<Freedom> freedom_;
  Improvement done_;
};

/// 1 where the angles are just as wanted, less where they are worse, ≤ 0 for a flat or inverted tet.
double Improver::quality_of(const Tet& tet) const {
  const std::array<Vec3, 4> p{mesh_.position(tet[0]), mesh_.position(tet[1]), mesh_.position(tet[2]),
                              mesh_.position(tet[3])};
  if (!((p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) > 0)) return nothing;
  std::array<Vec3, 4> outward;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& c = detail::face_corners[f];
    outward[f] = (p[c[1]] - p[c[0]]).cross(p[c[2]] - p[c[0]]);
    const double size = outward[f].norm();
    if (!(size > 0)) return nothing;
    outward[f] /= size;
  }
  double lowest = 1, highest = -1;  // of the cosines
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double cosine = -outward[i].dot(outward[j]);
      lowest = std::min(lowest, cosine);
      highest = std::max(highest, cosine);
    }
  constexpr double degrees = 180 / std::numbers::pi;
  const double smallest = std::acos(std::min(highest, 1.0)) * degrees;
  const double largest = std::acos(std::max(lowest, -1.0)) * degrees;
  return std::min(smallest / options_.min_dihedral, (180 - largest) / (180 - options_.max_dihedral));
}

double Improver::worst(const std::vector<std::uint32_t>& tets) const {
  double least = std::numeric_limits<double>::infinity();
  for (const std::uint32_t t : tets) least = std::min(least, quality_of(mesh_.tets[t]));
  return least;
}

/// Alive and worse than wanted, the worst first.
std::vector<std::uint32_t> Improver::bad_tets() const {
  std::vector<std::pair<double, std::uint32_t>> bad;
  for (std::uint32_t t = 0; t < mesh_.tets.size(); ++t)
    if (alive_[t] != 0)
      if (const double q = quality_of(mesh_.tets[t]); q < 1) bad.emplace_back(q, t);
  std::sort(bad.begin(), bad.end());
  std::vector<std::uint32_t> tets;
  for (const auto& [q, t] : bad) tets.push_back(t);
  return tets;
}

void Improver::find_freedom() {
  struct Sides {
    std::int32_t front = 0, back = 0;  // regions; 0 outside
    std::array<VertexId, 3> corners{};
  };
  std::map<std::array<std::uint32_t, 3>, Sides> faces;
  for (std::size_t t = 0; t < mesh_.tet_count(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& c = detail::face_corners[f];
      const std::array<VertexId, 3> corners{mesh_.tets[t][c[0]], mesh_.tets[t][c[1]], mesh_.tets[t][c[2]]};
      std::array<std::uint32_t, 3> key{corners[0].value, corners[1].value, corners[2].value};
      std::sort(key.begin(), key.end());
      const auto [entry, first] = faces.try_emplace(key, Sides{mesh_.regions[t], 0, corners});
      if (!first) entry->second.back = mesh_.regions[t];
    }
  freedom_.resize(mesh_.vertex_count());
  std::vector<std::set<std::pair<std::int32_t, std::int32_t>>> meeting(mesh_.vertex_count());
  for (const auto& [key, sides] : faces) {
    if (sides.front == sides.back) continue;
    const double sign = sides.front < sides.back ? -1 : 1;
    const Vec3& a = mesh_.position(sides.corners[0]);
    const Vec3 normal = sign * (mesh_.position(sides.corners[1]) - a).cross(mesh_.position(sides.corners[2]) - a);
    for (const VertexId v : sides.corners) {
      freedom_[v.index()].boundary = true;
      freedom_[v.index()].normal += normal;
      meeting[v.index()].emplace(std::minmax(sides.front, sides.back));
    }
  }
  for (std::size_t v = 0; v < freedom_.size(); ++v) {
    Freedom& f = freedom_[v];
    f.home = mesh_.positions[v];
    if (meeting[v].size() > 1) f.normal.setZero();
    if (f.normal.norm() > 0) f.normal.normalize();
    double sum = 0;
    std::size_t count = 0;
    for (const std::uint32_t t : around_[v])
      for (const VertexId w : mesh_.tets[t])
        if (w.index() != v) {
          sum += (mesh_.position(w) - f.home).norm();
          ++count;
        }
    f.edge = count > 0 ? sum / static_cast<double>(count) : 0;
  }
}

bool Improver::allowed(VertexId v, const Vec3& place) const {
  const Freedom& f = freedom_[v.index()];
  if (!f.boundary) return true;
  const Vec3 gone = place - f.home;
  const double across = std::abs(gone.dot(f.normal));
  if (f.normal.isZero()) return gone.norm() <= options_.across * f.edge;
  return across <= options_.across * f.edge && gone.norm() <= options_.along * f.edge;
}

/// Pattern search for the place where the worst tet around the vertex is best.
bool Improver::move(VertexId v) {
  static const std::array<Vec3, 14> directions = [] {
    std::array<Vec3, 14> d;
    for (int axis = 0; axis < 3; ++axis) {
      d[static_cast<std::size_t>(2 * axis)] = Vec3::Unit(axis);
      d[static_cast<std::size_t>(2 * axis + 1)] = -Vec3::Unit(axis);
    }
    for (int corner = 0; corner < 8; ++corner)
      d[static_cast<std::size_t>(6 + corner)] =
          Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1).normalized();
    return d;
  }();
  const std::vector<std::uint32_t>& tets = around_[v.index()];
  Vec3& place = mesh_.positions[v.index()];
  const double before = worst(tets);
  double best = before;
  for (double step = 0.25 * freedom_[v.index()].edge; step > 0.004 * freedom_[v.index()].edge;) {
    const Vec3 from = place;
    Vec3 best_place = from;
    for (const Vec3& direction : directions) {
      place = from + step * direction;
      if (!allowed(v, place)) continue;
      if (const double q = worst(tets); q > best + 1e-9) {
        best = q;
        best_place = place;
      }
    }
    place = best_place;
    if (best_place == from) step /= 2;
  }
  if (best <= before + 1e-6) return false;
  ++done_.moves;
  return true;
}

void Improver::take_out(std::uint32_t t) {
  alive_[t] = 0;
  for (const VertexId v : mesh_.tets[t]) std::erase(around_[v.index()], t);
}

/// Puts tets in the place of others of the same region.
void Improver::replace(const std::vector<std::uint32_t>& old, const std::vector<Tet>& fresh) {
  const std::int32_t region = mesh_.regions[old.front()];
  for (const std::uint32_t t : old) take_out(t);
  for (const Tet& tet : fresh) {
    mesh_.tets.push_back(tet);
    mesh_.regions.push_back(region);
    alive_.push_back(1);
    hang_in(static_cast<std::uint32_t>(mesh_.tets.size() - 1));
  }
}

std::vector<std::uint32_t> Improver::tets_of_edge(VertexId a, VertexId b) const {
  std::vector<std::uint32_t> tets;
  for (const std::uint32_t t : around_[a.index()])
    if (std::find(mesh_.tets[t].begin(), mesh_.tets[t].end(), b) != mesh_.tets[t].end()) tets.push_back(t);
  return tets;
}

/// The vertices around an edge in order, counter-clockwise seen from b; empty unless the edge lies inside one region.
std::vector<VertexId> Improver::ring_of(VertexId a, VertexId b, const std::vector<std::uint32_t>& tets) const {
  std::map<VertexId, VertexId> next;
  for (const std::uint32_t t : tets) {
    if (mesh_.regions[t] != mesh_.regions[tets.front()]) return {};
    std::array<VertexId, 2> others{};
    std::size_t n = 0;
    for (const VertexId v : mesh_.tets[t])
      if (v != a && v != b) others[n++] = v;
    if (!(signed_volume(mesh_.position(a), mesh_.position(others[0]), mesh_.position(others[1]), mesh_.position(b)) >
          0))
      std::swap(others[0], others[1]);
    if (!next.emplace(others[0], others[1]).second) return {};
  }
  std::vector<VertexId> ring{next.begin()->first};
  while (ring.size() <= tets.size()) {
    const auto step = next.find(ring.back());
    if (step == next.end()) return {};  // the edge lies on a boundary
    if (step->second == ring.front()) return ring.size() == tets.size() ? ring : std::vector<VertexId>{};
    ring.push_back(step->second);
  }
  return {};
}

/// Of all ways to span the ring with triangles, each making one tet with a and one with b, the one whose worst tet is
/// best (dynamic programming over the ring's polygon); empty if none is better than asked.
std::vector<Tet> Improver::best_filling(VertexId a, VertexId b, const std::vector<VertexId>& ring,
                                        double better_than) const {
  const std::size_t n = ring.size();
  std::vector<std::vector<double>> best(n, std::vector<double>(n, std::numeric_limits<double>::infinity()));
  std::vector<std::vector<std::size_t>> choice(n, std::vector<std::size_t>(n, 0));
  for (std::size_t span = 2; span < n; ++span)
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t j = i + span;
      best[i][j] = nothing;
      for (std::size_t k = i + 1; k < j; ++k) {
        double q = std::min(best[i][k], best[k][j]);
        if (q > better_than) q = std::min(q, quality_of({a, ring[i], ring[k], ring[j]}));
        if (q > better_than) q = std::min(q, quality_of({b, ring[i], ring[j], ring[k]}));
        if (q > best[i][j]) {
          best[i][j] = q;
          choice[i][j] = k;
        }
      }
    }
  if (!(best[0][n - 1] > better_than + 1e-6)) return {};
  std::vector<Tet> tets;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, n - 1}};
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    if (j - i < 2) continue;
    const std::size_t k = choice[i][j];
    tets.push_back({a, ring[i], ring[k], ring[j]});
    tets.push_back({b, ring[i], ring[j], ring[k]});
    open.emplace_back(i, k);
    open.emplace_back(k, j);
  }
  return tets;
}

bool Improver::remove_edge(VertexId a, VertexId b) {
  const std::vector<std::uint32_t> tets = tets_of_edge(a, b);
  if (tets.size() < 3 || tets.size() > 8) return false;
  const std::vector<VertexId> ring = ring_of(a, b, tets);
  if (ring.empty()) return false;
  const std::vector<Tet> filling = best_filling(a, b, ring, worst(tets));
  if (filling.empty()) return false;
  replace(tets, filling);
  ++done_.flips;
  return true;
}

/// Two tets on one face become three around a new edge.
bool Improver::remove_face(std::uint32_t t, std::size_t corner) {
  const Tet tet = mesh_.tets[t];
  std::array<VertexId, 3> face{};
  for (std::size_t c = 0; c < 3; ++c) face[c] = tet[static_cast<std::size_t>(detail::face_corners[corner][c])];
  for (const std::uint32_t other : around_[face[0].index()]) {
    const Tet& o = mesh_.tets[other];
    const auto has = [&](VertexId v) { return std::find(o.begin(), o.end(), v) != o.end(); };
    if (other == t || !has(face[1]) || !has(face[2])) continue;
    if (mesh_.regions[other] != mesh_.regions[t]) return false;
    const VertexId inside = tet[corner];
    const VertexId beyond = *std::find_if(
        o.begin(), o.end(), [&](VertexId v) { return std::find(face.begin(), face.end(), v) == face.end(); });
    // face winds counter-clockwise seen from beyond
    const std::vector<Tet> three{
        {inside, face[0], face[1], beyond}, {inside, face[1], face[2], beyond}, {inside, face[2], face[0], beyond}};
    const double before = worst({t, other});
    for (const Tet& fresh : three)
      if (!(quality_of(fresh) > before + 1e-6)) return false;
    replace({t, other}, three);
    ++done_.flips;
    return true;
  }
  return false;
}

/// Pulls a vertex inside a region into a neighbour.
bool Improver::collapse(VertexId gone, VertexId onto) {
  if (freedom_[gone.index()].boundary) return false;
  const std::vector<std::uint32_t> tets = around_[gone.index()];
  const double before = worst(tets);
  std::vector<Tet> kept;
  for (const std::uint32_t t : tets) {
    Tet tet = mesh_.tets[t];
    if (std::find(tet.begin(), tet.end(), onto) != tet.end()) continue;
    std::replace(tet.begin(), tet.end(), gone, onto);
    if (!(quality_of(tet) > before + 1e-6)) return false;
    kept.push_back(tet);
  }
  replace(tets, kept);
  ++done_.collapses;
  return true;
}

/// Tries everything on one tet; returns whether something got better.
bool Improver::mend(std::uint32_t t) {
  const Tet tet = mesh_.tets[t];
  bool better = false;
  for (const VertexId v : tet) better = move(v) || better;
  if (quality_of(tet) >= 1) return true;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      if (remove_edge(tet[i], tet[j])) return true;
  for (std::size_t f = 0; f < 4; ++f)
    if (remove_face(t, f)) return true;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      if (i != j && collapse(tet[i], tet[j])) return true;
  return better;
}

void Improver::compact() {
  std::vector<VertexId> number(mesh_.vertex_count(), VertexId::none());
  std::vector<std::uint8_t> used(mesh_.vertex_count(), 0);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    if (alive_[t] == 0) continue;
    for (const VertexId v : mesh_.tets[t]) used[v.index()] = 1;
    mesh_.tets[kept] = mesh_.tets[t];
    mesh_.regions[kept++] = mesh_.regions[t];
  }
  mesh_.tets.resize(kept);
  mesh_.regions.resize(kept);
  std::size_t vertices = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    mesh_.positions[vertices] = mesh_.positions[v];
    number[v] = VertexId(vertices++);
  }
  mesh_.positions.resize(vertices);
  for (Tet& tet : mesh_.tets)
    for (VertexId& v : tet) v = number[v.index()];
}

Improvement Improver::run() {
  for (int pass = 0; pass < options_.passes; ++pass) {
    const std::vector<std::uint32_t> bad = bad_tets();
    if (pass == 0) done_.bad_before = bad.size();
    bool better = false;
    for (const std::uint32_t t : bad)
      if (alive_[t] != 0 && quality_of(mesh_.tets[t]) < 1) better = mend(t) || better;
    if (!better) break;
  }
  done_.bad_after = bad_tets().size();
  compact();
  return done_;
}

}  // namespace

Improvement improve(TetMesh& mesh, const ImproveOptions& options) {
  return Improver(mesh, options).run();
}

}  // namespace calot
