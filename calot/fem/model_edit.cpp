// What an edit of the mesh, or of the tets' stiffness, changes in the step stiffness.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calot/base/error.h"
#include "calot/fem/assembly.h"
#include "calot/fem/model.h"
#include "calot/fem/support.h"

namespace calot {

/// Tets as they were before an edit, with old vertex numbers.
struct Model::Pieces {
  struct Piece {
    Tet vertices;
    std::int32_t region;
    double scale;
    TetShape shape;
  };
  std::vector<Piece> pieces;
  void add(const Model& model, TetId t) {
    const Tet& tet = model.mesh_.tet(t);
    pieces.push_back(
        {tet, model.mesh_.regions[t.index()], model.stiffness_scale_[t.index()], detail::shape_of(model.mesh_, tet)});
  }
};

namespace {

constexpr std::uint32_t no_site = ~0u;

/// The blocks between sites that a change concerns, to be looked up by row and column.
class Entries {
 public:
  Entries(std::size_t sites, std::vector<std::uint64_t> keys, std::vector<StiffnessChange::Entry>& entries)
      : entries_(entries), start_(sites + 1, 0) {
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    entries_.reserve(keys.size());
    for (const std::uint64_t key : keys) {
      const auto row = static_cast<std::uint32_t>(key >> 32);
      entries_.push_back({row, static_cast<std::uint32_t>(key), Mat3::Zero(), Mat3::Zero()});
      ++start_[row + 1];
    }
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
  }
  static std::uint64_t key(std::uint32_t row, std::uint32_t column) { return std::uint64_t{row} << 32 | column; }
  [[nodiscard]] StiffnessChange::Entry* find(std::uint32_t row, std::uint32_t column) {
    const auto first = entries_.begin() + start_[row], last = entries_.begin() + start_[row + 1];
    const auto at = std::lower_bound(
        first, last, column, [](const StiffnessChange::Entry& entry, std::uint32_t c) { return entry.column < c; });
    return at != last && at->column == column ? &*at : nullptr;
  }

 private:
  std::vector<StiffnessChange::Entry>& entries_;
  std::vector<std::uint32_t> start_;  // sites + 1
};

using Sites = std::array<std::uint32_t, 4>;

Sites sites_of(const Tet& tet, const std::vector<std::uint32_t>& site) {
  return {site[tet[0].index()], site[tet[1].index()], site[tet[2].index()], site[tet[3].index()]};
}

/// Calls body(a, b, entry) for each block of a tet that the change concerns.
template <class Body>
void for_each_block(const Sites& sites, Entries& entries, const Body& body) {
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4 && sites[a] != no_site; ++b)
      if (sites[b] != no_site)
        if (StiffnessChange::Entry* entry = entries.find(sites[a], sites[b]))
          body(static_cast<int>(a), static_cast<int>(b), *entry);
}

void add_keys(const Sites& sites, std::vector<std::uint64_t>& keys) {
  for (const std::uint32_t i : sites)
    for (const std::uint32_t j : sites)
      if (i != no_site && j != no_site) keys.push_back(Entries::key(i, j));
}

/// The shares of the vertices after an edit, as Model::apply says.
std::vector<double> shared_out(const std::vector<double>& shares, const Remap& remap) {
  std::vector<double> portion = shares, claims(shares.size(), 0.0);
  const auto claim_of_first = [](const AddedVertex& v) { return v.from == v.to ? 1.0 : 1 - v.weight; };
  const auto claim_of_second = [](const AddedVertex& v) { return v.from == v.to ? 0.0 : v.weight; };
  for (const AddedVertex& vertex : remap.added_from) {
    claims[vertex.from.index()] += claim_of_first(vertex);
    claims[vertex.to.index()] += claim_of_second(vertex);
  }
  for (std::size_t v = 0; v < shares.size(); ++v)
    if (claims[v] > 0) portion[v] /= claims[v] + (remap.vertex_to_new[v].valid() ? 1 : 0);
  std::vector<double> result;
  result.reserve(remap.vertex_to_old.size());
  for (const VertexId old : remap.vertex_to_old)
    if (old.valid()) result.push_back(portion[old.index()]);
  for (const AddedVertex& vertex : remap.added_from)
    result.push_back(claim_of_first(vertex) * portion[vertex.from.index()] +
                     claim_of_second(vertex) * portion[vertex.to.index()]);
  return result;
}

/// Those touched by the edit of the mesh and those whose share changed.
std::vector<VertexId> touched_by(const Remap& remap, const std::vector<double>& before,
                                 const std::vector<double>& after) {
  if (before.empty() || remap.added_vertices.empty()) return remap.touched;
  std::vector<VertexId> touched = remap.touched;
  for (const AddedVertex& vertex : remap.added_from)
    for (const VertexId v : {vertex.from, vertex.to}) {
      const VertexId now = remap.vertex_to_new[v.index()];
      if (now.valid() && after[now.index()] != before[v.index()]) touched.push_back(v);
    }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  return touched;
}

Remap identity_of(const TetMesh& mesh) {
  Remap remap;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) remap.vertex_to_new.emplace_back(v);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) remap.tet_to_new.emplace_back(t);
  remap.vertex_to_old = remap.vertex_to_new;
  remap.tet_to_old = remap.tet_to_new;
  return remap;
}

}  // namespace

Model::Pieces Model::pieces_that_go(const TopologyEdit& edit) const {
  Pieces went;
  for (const TetId t : edit.removed)
    if (t.index() < mesh_.tet_count()) went.add(*this, t);  // else the edit is refused in a moment
  for (const TetId t : reshaped_tets(mesh_, edit)) went.add(*this, t);
  return went;
}

void Model::follow(const Remap& remap) {
  std::vector<std::uint8_t> fixed;
  fixed.reserve(remap.vertex_to_old.size());
  for (const VertexId old : remap.vertex_to_old)
    if (old.valid()) fixed.push_back(fixed_[old.index()]);
  for (const AddedVertex& vertex : remap.added_from)
    fixed.push_back(fixed_[vertex.from.index()] != 0 && fixed_[vertex.to.index()] != 0 ? 1 : 0);
  std::vector<double> scale;
  scale.reserve(remap.tet_to_old.size());
  for (const TetId old : remap.tet_to_old)
    if (old.valid()) scale.push_back(stiffness_scale_[old.index()]);
  for (const TetId parent : remap.added_parents) scale.push_back(stiffness_scale_[parent.index()]);
  fixed_ = std::move(fixed);
  stiffness_scale_ = std::move(scale);
  if (dynamics_.mass_lumping == MassLumping::uniform) shares_ = shared_out(shares_, remap);
}

StiffnessChange Model::apply(const TopologyEdit& edit) {
  const Pieces went = pieces_that_go(edit);
  const std::vector<double> shares_before = edit.vertices.empty() ? std::vector<double>{} : shares_;
  StiffnessChange change;
  change.remap = calot::apply(mesh_, edit);
  follow(change.remap);
  change.struck = change.remap.orphaned;
  change.touched = touched_by(change.remap, shares_before, shares_);
  change.added = change.remap.added_vertices;
  for (const VertexId v : change.added) change.added_fixed.push_back(fixed_[v.index()]);
  std::vector<TetId> came;
  for (const TetId t : change.remap.reshaped) came.push_back(change.remap.tet_to_new[t.index()]);
  came.insert(came.end(), change.remap.added_tets.begin(), change.remap.added_tets.end());
  describe(change, went, came, shares_before);
  if (dynamics_.is_static()) change.unsupported = unsupported_part(mesh_, fixed_);
  return change;
}

StiffnessChange Model::scale_stiffness(std::span<const TetId> tets, std::span<const double> factors) {
  const auto refuse = [](const std::string& what) {
    throw InputError("stiffness scale", what, "give ascending tets and a factor > 0 for each");
  };
  if (tets.size() != factors.size())
    refuse("has " + std::to_string(factors.size()) + " factors for " + std::to_string(tets.size()) + " tets");
  for (std::size_t k = 0; k < tets.size(); ++k) {
    if (tets[k].index() >= mesh_.tet_count())
      refuse("names tet " + std::to_string(tets[k].value) + " of " + std::to_string(mesh_.tet_count()));
    if (k > 0 && !(tets[k - 1] < tets[k])) refuse("names its tets out of order or twice");
    if (!(factors[k] > 0) || !std::isfinite(factors[k]))
      refuse("of tet " + std::to_string(tets[k].value) + " is not a finite number > 0");
  }
  Pieces went;
  std::vector<TetId> came;
  for (std::size_t k = 0; k < tets.size(); ++k) {
    if (stiffness_scale_[tets[k].index()] == factors[k]) continue;
    went.add(*this, tets[k]);
    came.push_back(tets[k]);
    stiffness_scale_[tets[k].index()] = factors[k];
  }
  StiffnessChange change;
  change.remap = identity_of(mesh_);
  for (const TetId t : came) change.touched.insert(change.touched.end(), mesh_.tet(t).begin(), mesh_.tet(t).end());
  std::sort(change.touched.begin(), change.touched.end());
  change.touched.erase(std::unique(change.touched.begin(), change.touched.end()), change.touched.end());
  describe(change, went, came, {});
  return change;
}

void Model::describe(StiffnessChange& change, const Pieces& went, const std::vector<TetId>& came,
                     const std::vector<double>& shares_before) const {
  const Remap& remap = change.remap;
  const auto touched = static_cast<std::uint32_t>(change.touched.size());
  const std::size_t sites = touched + change.added.size();
  std::vector<std::uint32_t> old_site(remap.vertex_to_new.size(), no_site), site(mesh_.vertex_count(), no_site);
  std::vector<VertexId> vertex(sites);  // new ids
  for (std::uint32_t k = 0; k < sites; ++k) {
    vertex[k] = k < touched ? remap.vertex_to_new[change.touched[k].index()] : change.added[k - touched];
    site[vertex[k].index()] = k;
    if (k < touched) old_site[change.touched[k].index()] = k;
  }
  std::vector<std::uint64_t> keys;
  for (const Pieces::Piece& piece : went.pieces) add_keys(sites_of(piece.vertices, old_site), keys);
  for (const TetId t : came) add_keys(sites_of(mesh_.tet(t), site), keys);
  if (!shares_before.empty())
    for (std::uint32_t k = 0; k < sites; ++k) keys.push_back(Entries::key(k, k));
  Entries entries(sites, std::move(keys), change.entries);

  const detail::ElementSum sum(*this, dynamics_.mass_factor(), dynamics_.stiffness_factor());
  for (const Pieces::Piece& piece : went.pieces)
    for_each_block(sites_of(piece.vertices, old_site), entries, [&](int a, int b, StiffnessChange::Entry& entry) {
      entry.change -= sum.block(sum.region(piece.region), piece.scale, piece.shape, a, b);
    });
  const auto for_each_block_of = [&](TetId t, const auto& body) {
    const Sites here = sites_of(mesh_.tet(t), site);
    if (std::all_of(here.begin(), here.end(), [](std::uint32_t s) { return s == no_site; })) return;
    const detail::ElementSum::Region& region = sum.region(mesh_.regions[t.index()]);
    const TetShape shape = detail::shape_of(mesh_, mesh_.tet(t));
    for_each_block(here, entries, [&](int a, int b, StiffnessChange::Entry& entry) {
      body(entry, sum.block(region, stiffness_scale_[t.index()], shape, a, b));
    });
  };
  for (const TetId t : came)
    for_each_block_of(t, [](StiffnessChange::Entry& entry, const Mat3& block) { entry.change += block; });
  for (std::size_t t = 0; t < mesh_.tet_count(); ++t)
    for_each_block_of(TetId(t), [](StiffnessChange::Entry& entry, const Mat3& block) { entry.block += block; });
  if (shares_.empty()) return;
  for (std::uint32_t k = 0; k < sites; ++k) {
    StiffnessChange::Entry* entry = entries.find(k, k);
    const double share = shares_[vertex[k].index()];
    entry->block.diagonal().array() += sum.own_diagonal(share);
    if (k >= touched || !shares_before.empty())
      entry->change.diagonal().array() +=
          sum.own_diagonal(k < touched ? share - shares_before[change.touched[k].index()] : share);
  }
}

}  // namespace calot
