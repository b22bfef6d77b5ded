#include "app/lineage.h"

#include <algorithm>

namespace calot {
namespace {

using Origin = Lineage::Origin;

/// (1 − weight)·a + weight·b, ascending.
Origin between(const Origin& a, const Origin& b, double weight) {
  if (weight == 0) return a;
  if (weight == 1) return b;
  Origin mean;
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    const bool from_a = j == b.end() || (i != a.end() && i->old <= j->old);
    const bool from_b = i == a.end() || (j != b.end() && j->old <= i->old);
    Lineage::Share share{from_a ? i->old : j->old, 0};
    if (from_a) share.weight += (1 - weight) * i++->weight;
    if (from_b) share.weight += weight * j++->weight;
    mean.push_back(share);
  }
  return mean;
}

/// Old → new through one edit more.
template <class Id>
void lead_on(std::vector<Id>& to_new, const std::vector<Id>& step) {
  for (Id& id : to_new)
    if (id.valid()) id = step[id.index()];
}

template <class Id>
std::size_t count_valid(const std::vector<Id>& ids) {
  return static_cast<std::size_t>(std::count_if(ids.begin(), ids.end(), [](Id id) { return id.valid(); }));
}

}  // namespace

Lineage::Lineage(const TetMesh& mesh) : tets_now_(mesh.tet_count()) {
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    vertex_to_new_.emplace_back(v);
    origins_.push_back({{VertexId(v), 1.0}});
  }
  vertex_to_old_ = vertex_to_new_;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) tet_to_new_.emplace_back(t);
}

void Lineage::follow(const Remap& remap) {
  const std::vector<Origin> before = std::move(origins_);
  const std::vector<VertexId> oldest = std::move(vertex_to_old_);
  origins_.clear();
  vertex_to_old_.clear();
  for (const VertexId v : remap.vertex_to_old) {
    origins_.push_back(v.valid() ? before[v.index()] : Origin{});
    vertex_to_old_.push_back(v.valid() ? oldest[v.index()] : VertexId::none());
  }
  for (const MovedVertex& m : remap.moved)
    origins_[remap.vertex_to_new[m.vertex.index()].index()] =
        between(before[m.vertex.index()], before[m.to.index()], m.weight);
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    const AddedVertex& from = remap.added_from[k];
    origins_[remap.added_vertices[k].index()] =
        between(before[from.from.index()], before[from.to.index()], from.weight);
  }
  lead_on(vertex_to_new_, remap.vertex_to_new);
  lead_on(tet_to_new_, remap.tet_to_new);
  tets_now_ = remap.tet_to_old.size();
}

std::size_t Lineage::vertices_removed() const {
  return vertex_to_new_.size() - count_valid(vertex_to_new_);
}
std::size_t Lineage::vertices_added() const {
  return vertex_to_old_.size() - count_valid(vertex_to_old_);
}
std::size_t Lineage::vertices_moved() const {
  std::size_t moved = 0;
  for (const VertexId v : vertex_to_new_) moved += v.valid() && !in_place(v) ? 1 : 0;
  return moved;
}
std::size_t Lineage::tets_removed() const {
  return tet_to_new_.size() - count_valid(tet_to_new_);
}
std::size_t Lineage::tets_added() const {
  return tets_now_ - count_valid(tet_to_new_);
}

bool Lineage::in_place(VertexId v) const {
  const VertexId old = vertex_to_old_[v.index()];
  return old.valid() && origins_[v.index()].size() == 1 && origins_[v.index()].front().old == old;
}

}  // namespace calot
