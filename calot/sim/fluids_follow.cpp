// How fluids follow an edit: which faces it laid bare, and which sources they belong to.
#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "calot/sim/fluids.h"
#include "calot/sim/tear_faces.h"

namespace calot {
namespace {

constexpr std::uint32_t no_source = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t no_face = 4;

double area(const TetMesh& mesh, TetId tet, std::size_t f) {
  const auto face = detail::face_of(mesh.tet(tet), f);
  const Vec3 ab = mesh.position(face[1]) - mesh.position(face[0]), ac = mesh.position(face[2]) - mesh.position(face[0]);
  return 0.5 *
         Vec3(ab.y() * ac.z() - ab.z() * ac.y(), ab.z() * ac.x() - ab.x() * ac.z(), ab.x() * ac.y() - ab.y() * ac.x())
             .norm();
}

Vec3 middle(const TetMesh& mesh, TetId tet, std::size_t f) {
  const auto face = detail::face_of(mesh.tet(tet), f);
  return (mesh.position(face[0]) + mesh.position(face[1]) + mesh.position(face[2])) / 3;
}

/// Number of the face-connected part of each tet.
std::vector<std::uint32_t> parts(std::span<const detail::Neighbours> neighbours) {
  std::vector<std::uint32_t> part(neighbours.size(), no_source), stack;
  for (std::uint32_t first = 0, number = 0; first < part.size(); ++first) {
    if (part[first] != no_source) continue;
    part[first] = number;
    stack.assign(1, first);
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (const TetId next : neighbours[t]) {
        if (!next.valid() || part[next.index()] != no_source) continue;
        part[next.index()] = number;
        stack.push_back(next.value);
      }
    }
    ++number;
  }
  return part;
}

struct Group {
  double area = 0;
  std::vector<std::uint32_t> faces;
};

/// A corner of an open face; those with equal key and vertex join their faces.
struct Corner {
  std::uint64_t key;
  std::uint32_t vertex, face;
  friend auto operator<=>(const Corner&, const Corner&) = default;
};

/// Groups of faces that share corners, the largest area first.
std::vector<Group> groups_of(std::vector<Corner> corners, const std::vector<double>& areas) {
  std::sort(corners.begin(), corners.end());
  std::vector<std::uint32_t> parent(areas.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t c = 1; c < corners.size(); ++c) {
    if (corners[c].vertex != corners[c - 1].vertex || corners[c].key != corners[c - 1].key) continue;
    const std::uint32_t a = find(corners[c].face), b = find(corners[c - 1].face);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::vector<Group> groups(areas.size());
  for (std::uint32_t k = 0; k < areas.size(); ++k) {
    groups[find(k)].area += areas[k];
    groups[find(k)].faces.push_back(k);
  }
  std::erase_if(groups, [](const Group& group) { return group.faces.empty(); });
  std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.area > b.area; });
  return groups;
}

}  // namespace

bool Fluids::lumen_between(TetId a, TetId b) const {
  return detail::share_lumen(tissue(a).vessel, tissue(b).vessel);
}

/// The face of the parent that face f of a piece lies in; no_face where it is inside the parent. `piece` has new ids.
std::size_t Fluids::parent_face(const Remap& remap, const Tet& parent, const Tet& piece, std::size_t f) const {
  const std::size_t first_added = remap.vertex_to_old.size() - remap.added_vertices.size();
  for (std::size_t g = 0; g < 4; ++g) {
    const auto within = [&](VertexId old) { return old != parent[g] && detail::has(parent, old); };
    bool all = true;
    for (const VertexId v : detail::face_of(piece, f)) {
      const VertexId old = remap.vertex_to_old[v.index()];
      if (old.valid()) {
        all = all && within(old);
        continue;
      }
      const AddedVertex& added = remap.added_from[v.index() - first_added];
      all = all && (added.weight >= 1 || within(added.from)) && (added.weight <= 0 || within(added.to));
    }
    if (all) return g;
  }
  return no_face;
}

/// A face laid bare: an opening of the vessel, a raw face, or both. Its source is found by `group_faces`.
void Fluids::open_face(const TetMesh& mesh, TetId tet, std::size_t f, const TissueProperties& tissue, bool lumen) {
  OpenFace open;
  open.tet = tet;
  open.face = static_cast<std::uint8_t>(f);
  open.source = no_source;
  open.area = area(mesh, tet, f);
  if (tissue.ooze_rate > 0) open_.push_back(open);
  open.lumen = true;
  if (lumen) open_.push_back(open);
}

/// Pieces keep the open faces of their parents; their other bare faces are new. Kinds and neighbours are still the old.
void Fluids::look_at_pieces(const Remap& remap, const TetMesh& mesh, std::vector<detail::Neighbours>& after) {
  const std::vector<OpenFace> before = open_;
  const auto by_tet = [](const OpenFace& open, TetId tet) { return open.tet < tet; };
  open_.clear();
  for (OpenFace open : before) {
    open.tet = remap.tet_to_new[open.tet.index()];
    if (open.tet.valid()) open_.push_back(open);
  }
  for (std::size_t k = 0; k < remap.added_tets.size(); ++k) {
    const TetId tet = remap.added_tets[k], parent = remap.added_parents[k];
    const auto first = std::lower_bound(before.begin(), before.end(), parent, by_tet);
    for (std::size_t f = 0; f < 4; ++f) {
      if (after[tet.index()][f].valid()) continue;
      const std::size_t g = parent_face(remap, tets_[parent.index()], mesh.tet(tet), f);
      const TetId was = g == no_face ? parent : neighbours_[parent.index()][g];
      if (was.valid()) {
        open_face(mesh, tet, f, tissue(parent), lumen_between(parent, was));
        continue;
      }
      for (auto open = first; open != before.end() && open->tet == parent; ++open) {
        if (open->face != g) continue;
        OpenFace piece = *open;
        piece.tet = tet;
        piece.face = static_cast<std::uint8_t>(f);
        piece.area = area(mesh, tet, f);
        open_.push_back(piece);
      }
    }
  }
}

/// Faces of tets that stayed, whose neighbour went or was separated.
void Fluids::look_at_survivors(const Remap& remap, const TetMesh& mesh, const VertexTets& around,
                               std::vector<detail::Neighbours>& after) {
  std::vector<std::uint8_t> near(mesh.tet_count(), 0);
  const auto mark = [&](VertexId v) {
    for (std::uint32_t k = around.start[v.index()]; k < around.start[v.index() + 1]; ++k)
      near[around.tets[k].index()] = 1;
  };
  for (const VertexId v : remap.touched) mark(remap.vertex_to_new[v.index()]);
  for (const VertexId v : remap.added_vertices) mark(v);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const TetId old = remap.tet_to_old[t];
    if (!old.valid() || near[t] != 0) {
      for (std::size_t f = 0; f < 4; ++f) after[t][f] = detail::across(mesh, around, TetId(t), f);
    } else {
      for (std::size_t f = 0; f < 4; ++f) {
        const TetId was = neighbours_[old.index()][f];
        after[t][f] = was.valid() ? remap.tet_to_new[was.index()] : was;
      }
    }
  }
  look_at_pieces(remap, mesh, after);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const TetId old = remap.tet_to_old[t];
    if (!old.valid() || near[t] == 0) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      const TetId was = neighbours_[old.index()][f];
      if (was.valid() && !after[t][f].valid()) open_face(mesh, TetId(t), f, tissue(old), lumen_between(old, was));
    }
  }
}

void Fluids::carry_faces(const Remap& remap, const TetMesh& mesh, const VertexTets& around) {
  std::vector<detail::Neighbours> after(mesh.tet_count());
  look_at_survivors(remap, mesh, around, after);
  neighbours_ = std::move(after);
  tets_ = mesh.tets;
  kind_.resize(mesh.tet_count());
  for (std::size_t t = 0; t < kind_.size(); ++t) kind_[t] = kind_of_region_.at(mesh.regions[t]);
  std::sort(open_.begin(), open_.end(), [](const OpenFace& a, const OpenFace& b) {
    return std::tie(a.tet, a.face, a.lumen) < std::tie(b.tet, b.face, b.lumen);
  });
  std::vector<std::uint8_t> supply(mesh.vertex_count(), 0);
  for (std::size_t v = 0; v < supply.size(); ++v)
    if (const VertexId old = remap.vertex_to_old[v]; old.valid()) supply[v] = supply_[old.index()];
  for (std::size_t k = 0; k < remap.added_vertices.size(); ++k) {
    const AddedVertex& added = remap.added_from[k];
    supply[remap.added_vertices[k].index()] = supply_[added.from.index()] & supply_[added.to.index()];
  }
  supply_ = std::move(supply);
}

/// A source's place: the open face nearest to the middle of all its faces.
void Fluids::place(FluidSource& source, const TetMesh& mesh, std::span<const std::uint32_t> faces) const {
  Vec3 centre = Vec3::Zero();
  double total = 0;
  for (const std::uint32_t k : faces) {
    centre += open_[k].area * middle(mesh, open_[k].tet, open_[k].face);
    total += open_[k].area;
  }
  if (total > 0) centre /= total;
  double best = std::numeric_limits<double>::infinity();
  for (const std::uint32_t k : faces) {
    const double distance = (middle(mesh, open_[k].tet, open_[k].face) - centre).norm();
    if (distance >= best) continue;
    best = distance;
    source.place = {detail::face_of(mesh.tet(open_[k].tet), open_[k].face), Vec3::Constant(1.0 / 3), open_[k].tet};
  }
}

/// Open faces of one region, kind and part that touch make one source. Where a source comes apart, its largest piece
/// keeps the number; where two meet, the lower number stays and the other ends.
void Fluids::group_faces(const TetMesh& mesh) {
  std::vector<Corner> corners;
  std::vector<double> areas;
  const std::vector<std::uint32_t> part = open_.empty() ? std::vector<std::uint32_t>() : parts(neighbours_);
  for (std::uint32_t k = 0; k < open_.size(); ++k) {
    const OpenFace& open = open_[k];
    const std::uint64_t kind = 2u * kind_[open.tet.index()] + (open.lumen ? 1u : 0u);
    for (const VertexId v : detail::face_of(mesh.tet(open.tet), open.face))
      corners.push_back({(kind << 32) | part[open.tet.index()], v.value, k});
    areas.push_back(open.area);
  }
  std::vector<std::uint8_t> alive(sources_.size(), 0);
  for (const Group& group : groups_of(std::move(corners), areas)) {
    std::uint32_t id = no_source;
    for (const std::uint32_t k : group.faces) {
      const std::uint32_t own = open_[k].source;
      if (own != no_source && alive[index_of(own)] == 0) id = std::min(id, own);
    }
    if (id == no_source) {
      id = new_source(mesh, open_[group.faces[0]]);
      alive.push_back(0);
    }
    alive[index_of(id)] = 1;
    for (const std::uint32_t k : group.faces) open_[k].source = id;
    place(sources_[index_of(id)], mesh, group.faces);
  }
  for (std::size_t s = 0; s < sources_.size(); ++s)
    if (alive[s] == 0 && sources_[s].kind != FluidSourceKind::injury) {
      sources_[s].ended = true;
      sources_[s].rate = sources_[s].open_area = 0;
    }
}

std::uint32_t Fluids::new_source(const TetMesh& mesh, const OpenFace& open) {
  FluidSource source;
  source.id = sources_.empty() ? 0 : sources_.back().id + 1;
  source.kind = open.lumen ? FluidSourceKind::vessel : FluidSourceKind::ooze;
  source.fluid = open.lumen ? fluid_of(tissue(open.tet).vessel) : Fluid::blood;
  source.region = mesh.regions[open.tet.index()];
  source.position = middle(mesh, open.tet, open.face);
  source.fed = !open.lumen;
  sources_.push_back(source);
  injury_rate_.push_back(0);
  return source.id;
}

/// Injuries keep to their triangle, or to its heaviest vertex that is left; without any they end.
void Fluids::follow_injuries(const Remap& remap, const TetMesh& mesh, const VertexTets& around) {
  for (FluidSource& source : sources_) {
    if (source.kind != FluidSourceKind::injury || source.ended) continue;
    SurfacePoint& point = source.place;
    const TetId tet = remap.tet_to_new[point.tet.index()];
    VertexId heaviest;
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      point.vertices[k] = remap.vertex_to_new[point.vertices[k].index()];
      const double weight = point.weights[static_cast<Eigen::Index>(k)];
      if (!point.vertices[k].valid() || weight <= most) continue;
      most = weight;
      heaviest = point.vertices[k];
    }
    point.tet = tet;
    if (tet.valid()) continue;
    if (heaviest.valid() && move_to(point, heaviest, source.region, mesh, around)) continue;
    source.ended = true;
    source.rate = 0;
  }
}

/// Puts a point on a bare face of the region at a vertex. @return false where there is none
bool Fluids::move_to(SurfacePoint& point, VertexId vertex, std::int32_t region, const TetMesh& mesh,
                     const VertexTets& around) const {
  for (std::uint32_t e = around.start[vertex.index()]; e < around.start[vertex.index() + 1]; ++e) {
    const TetId tet = around.tets[e];
    if (mesh.regions[tet.index()] != region) continue;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto face = detail::face_of(mesh.tet(tet), f);
      const auto corner = std::find(face.begin(), face.end(), vertex);
      if (corner == face.end() || neighbours_[tet.index()][f].valid()) continue;
      point = {face, Vec3::Unit(corner - face.begin()), tet};
      return true;
    }
  }
  return false;
}

void Fluids::follow(const Remap& remap, const TetMesh& mesh, const VertexTets& around) {
  carry_faces(remap, mesh, around);
  group_faces(mesh);
  follow_injuries(remap, mesh, around);
  ways_known_ = false;
}

void Fluids::append_state(std::string& bytes) const {
  for (const OpenFace& open : open_) {
    for (const std::uint32_t value : {open.tet.value, std::uint32_t{open.face}, open.lumen ? 1u : 0u, open.source})
      detail::append_bytes(bytes, value);
    for (const double value : {open.area, open.age}) detail::append_bytes(bytes, value);
  }
  for (const FluidSource& s : sources_) {
    detail::append_bytes(bytes, s.id);
    for (const VertexId v : s.place.vertices) detail::append_bytes(bytes, v.value);
    for (const double value : {s.position.x(), s.position.y(), s.position.z(), s.open_area, s.rate, s.shed, s.pooled})
      detail::append_bytes(bytes, value);
    detail::append_bytes(bytes, s.fed);
    detail::append_bytes(bytes, s.ended);
  }
  detail::append_bytes(bytes, injury_rate_);
  detail::append_bytes(bytes, supply_);
  for (const double value : {totals_.blood_lost, totals_.bile_spilled, totals_.blood_rate, totals_.bile_rate,
                             totals_.sucked, totals_.gallbladder_left, totals_.biliary_tree_left})
    detail::append_bytes(bytes, value);
}

}  // namespace calot
