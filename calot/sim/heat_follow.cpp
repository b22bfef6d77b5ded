// How heat follows an edit of the mesh, and what makes up its state.
#include <algorithm>

#include "calot/sim/heat.h"
#include "calot/sim/tear_faces.h"
#include "calot/sim/tissue_state.h"

namespace calot {

/// Energy in the tets that go and leave no pieces [J]. Their corners are found in the adjacency before the edit.
double TissueHeat::energy_leaving(const Remap& remap) const {
  const std::size_t old_tets = remap.tet_to_new.size();
  std::vector<std::uint8_t> goes(old_tets, 0), filled(old_tets, 0);
  for (std::size_t t = 0; t < old_tets; ++t) goes[t] = remap.tet_to_new[t].valid() ? 0 : 1;
  for (const TetId parent : remap.added_parents) goes[parent.index()] = 0;
  std::vector<Tet> corners(old_tets);
  for (std::size_t v = 0; v + 1 < around_.start.size(); ++v)
    for (std::uint32_t k = around_.start[v]; k < around_.start[v + 1]; ++k) {
      const std::size_t t = around_.tets[k].index();
      if (goes[t] != 0) corners[t][filled[t]++] = VertexId(v);
    }
  double energy = 0;
  for (std::size_t t = 0; t < old_tets; ++t)
    if (goes[t] != 0) energy += corner_energy(TetId(t), corners[t]) + dried_[t];
  return energy;
}

/// Pieces share what has dried of their parent by volume.
void TissueHeat::carry_tets(const Remap& remap, const TetMesh& mesh) {
  const std::size_t m = remap.tet_to_old.size();
  std::vector<Element> elements(m);
  std::vector<double> dried(m, 0), pieces(remap.tet_to_new.size(), 0);
  std::vector<std::uint8_t> level(m, 0);
  for (std::size_t t = 0; t < m; ++t) {
    const TetId old = remap.tet_to_old[t];
    if (!old.valid()) continue;
    elements[t] = elements_[old.index()];
    dried[t] = dried_[old.index()];
    level[t] = level_[old.index()];
  }
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k) {
    const TetId tet = remap.added_tets[k];
    elements[tet.index()] = element(mesh, tet);
    pieces[remap.added_parents[k].index()] += elements[tet.index()].volume;
  }
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k) {
    const std::size_t tet = remap.added_tets[k].index(), parent = remap.added_parents[k].index();
    dried[tet] = dried_[parent] * elements[tet].volume / pieces[parent];
    level[tet] = level_[parent];
  }
  elements_ = std::move(elements);
  dried_ = std::move(dried);
  level_ = std::move(level);
}

/// Shapes and bare faces that the edit changed. A tet in a new shape is as dry as before.
void TissueHeat::measure_again(const Remap& remap, const TetMesh& mesh) {
  const auto for_each_around = [&](VertexId v, const auto& body) {
    for (std::uint32_t k = around_.start[v.index()]; k < around_.start[v.index() + 1]; ++k) body(around_.tets[k]);
  };
  std::vector<std::uint8_t> stale(mesh.tet_count(), 0);
  const auto mark = [&](VertexId v, std::uint8_t how) {
    if (v.valid()) for_each_around(v, [&](TetId tet) { stale[tet.index()] = std::max(stale[tet.index()], how); });
  };
  for (const VertexId v : remap.touched) mark(remap.vertex_to_new[v.index()], 1);
  for (const VertexId v : remap.added_vertices) mark(v, 1);
  for (const MovedVertex& moved : remap.moved) mark(remap.vertex_to_new[moved.vertex.index()], 2);
  for (std::size_t t = 0; t < stale.size(); ++t) {
    if (stale[t] == 2) {
      const double volume = elements_[t].volume;
      elements_[t] = element(mesh, TetId(t));
      dried_[t] *= elements_[t].volume / volume;
    }
    if (stale[t] > 0) measure_surface(mesh, TetId(t));
  }
}

void TissueHeat::follow(const Remap& remap, const TetMesh& mesh, const VertexTets& around) {
  const double before = stored(), removed = energy_leaving(remap);
  around_ = around;
  carry_tets(remap, mesh);
  measure_again(remap, mesh);
  sum_vertices(mesh);
  carry_vertices(remap, mesh);
  ledger_.removed += removed;
  ledger_.reshaped += stored() - (before - removed);
}

void TissueHeat::carry_vertices(const Remap& remap, const TetMesh& mesh) {
  for (auto* field : {&excess_, &peak_, &dose_, &damage_, &coagulated_, &charred_}) *field = carry_over(*field, remap);
  const std::size_t n = mesh.vertex_count();
  hot_.assign(n, 0);
  harmed_.assign(n, 0);
  tet_is_active_.assign(mesh.tet_count(), 0);
  vertex_is_active_.assign(n, 0);
  active_tets_.clear();
  active_vertices_.clear();
  for (auto* field : {&heating_, &solution_, &residual_, &direction_, &product_, &diagonal_, &inverse_})
    field->assign(n, 0);
  for (std::size_t v = 0; v < n; ++v)
    if (std::abs(excess_[v]) > 0.5 * options_.threshold) hot_[v] = 2;
}

void TissueHeat::append_state(std::string& bytes) const {
  for (const auto* field : {&excess_, &peak_, &dose_, &damage_, &coagulated_, &charred_, &dried_})
    detail::append_bytes(bytes, *field);
  detail::append_bytes(bytes, level_);
  detail::append_bytes(bytes, hot_);
  detail::append_bytes(bytes, active_tets_);
  for (const double value : {ledger_.supplied, ledger_.perfused, ledger_.exchanged, ledger_.removed, ledger_.reshaped})
    detail::append_bytes(bytes, value);
  detail::append_bytes(bytes, steps_);
}

}  // namespace calot
