// Where tubes are fed, when nobody says it.
#include <algorithm>

#include "calot/base/error.h"
#include "calot/sim/fluids.h"
#include "calot/sim/tear_faces.h"

namespace calot {
namespace {

/// Ducts nearer to the liver than any other part of the tree.
bool is_upstream(const TetMesh& mesh, TetId tet) {
  const auto name = mesh.region_names.find(mesh.regions[tet.index()]);
  return name != mesh.region_names.end() &&
         (name->second == "common hepatic duct" || name->second == "aberrant right hepatic duct");
}

Vec3 mean_position(const TetMesh& mesh, std::span<const TetId> tets) {
  Vec3 sum = Vec3::Zero();
  for (const TetId t : tets)
    for (const VertexId v : mesh.tet(t)) sum += mesh.position(v) / 4;
  return tets.empty() ? sum : Vec3(sum / static_cast<double>(tets.size()));
}

VertexId farthest(const TetMesh& mesh, std::span<const TetId> tets, const Vec3& from) {
  VertexId best = mesh.tet(tets[0])[0];
  for (const TetId t : tets)
    for (const VertexId v : mesh.tet(t))
      if ((mesh.position(v) - from).squaredNorm() > (mesh.position(best) - from).squaredNorm()) best = v;
  return best;
}

}  // namespace

std::vector<VertexId> supply_vertices(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
                                      std::span<const std::uint8_t> fixed) {
  if (fixed.size() != mesh.vertex_count())
    throw InputError("supplies", "fixed flags are not of this mesh", "give one for each vertex");
  // Trees of tubes: the sacs are taken out, so that they part what hangs on them.
  std::vector<TissueProperties> kinds{{}};
  std::vector<std::uint8_t> kind(mesh.tet_count(), 0);
  std::map<std::int32_t, std::uint8_t> number;
  std::vector<TetId> sac;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const auto tissue = properties.find(mesh.regions[t]);
    if (tissue == properties.end()) continue;
    const VesselKind vessel = tissue->second.vessel;
    if (vessel == VesselKind::gallbladder || vessel == VesselKind::gallbladder_wall) sac.emplace_back(t);
    if (vessel != VesselKind::artery && vessel != VesselKind::bile_duct) continue;
    const auto [entry, added] = number.try_emplace(mesh.regions[t], static_cast<std::uint8_t>(kinds.size()));
    if (added) kinds.push_back(tissue->second);
    kind[t] = entry->second;
  }
  const VertexTets around = vertex_tets(mesh);
  std::vector<detail::Neighbours> neighbours(mesh.tet_count());
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    for (std::size_t f = 0; f < 4; ++f)
      neighbours[t][f] = kind[t] == 0 ? TetId::none() : detail::across(mesh, around, TetId(t), f);
  detail::VesselGraph graph;
  graph.build(mesh, neighbours, kind, kinds);
  std::vector<VertexId> supplies;
  for (const std::vector<TetId>& tree : graph.components()) {
    std::vector<VertexId> held, upstream;
    for (const TetId t : tree)
      for (const VertexId v : mesh.tet(t)) {
        if (fixed[v.index()] == 0) continue;
        held.push_back(v);
        if (is_upstream(mesh, t)) upstream.push_back(v);
      }
    if (!upstream.empty()) held = upstream;
    if (held.empty()) held.push_back(farthest(mesh, tree, mean_position(mesh, sac.empty() ? tree : sac)));
    supplies.insert(supplies.end(), held.begin(), held.end());
  }
  std::sort(supplies.begin(), supplies.end());
  supplies.erase(std::unique(supplies.begin(), supplies.end()), supplies.end());
  return supplies;
}

}  // namespace calot
