// Edits and what they say they did.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "calot/base/error.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "calot/mesh/surface.h"
#include "calot/mesh/topology_edit.h"
#include "tests/support/edits.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

double volume_of(const TetMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) sum += signed_volume(mesh, TetId(t));
  return sum;
}

template <class Id>
void expect_inverse(const std::vector<Id>& to_new, const std::vector<Id>& to_old, const std::vector<Id>& added) {
  Id last;
  for (std::size_t i = 0; i < to_new.size(); ++i) {
    if (!to_new[i].valid()) continue;
    ASSERT_LT(to_new[i].index(), to_old.size());
    EXPECT_EQ(to_old[to_new[i].index()], Id(i));
    EXPECT_TRUE(!last.valid() || last < to_new[i]) << "survivors keep their order";
    last = to_new[i];
  }
  const auto gone = static_cast<std::size_t>(std::count(to_new.begin(), to_new.end(), Id::none()));
  EXPECT_EQ(to_old.size(), to_new.size() - gone + added.size());
  for (std::size_t k = 0; k < added.size(); ++k) {
    EXPECT_EQ(added[k].index(), to_new.size() - gone + k) << "added ones follow the survivors";
    EXPECT_FALSE(to_old[added[k].index()].valid());
  }
}

/// Checks a remap against a straightforward account of the same edit.
void expect_consistent(const TetMesh& before, const TetMesh& after, const TopologyEdit& edit, const Remap& remap) {
  expect_inverse(remap.vertex_to_new, remap.vertex_to_old, remap.added_vertices);
  expect_inverse(remap.tet_to_new, remap.tet_to_old, remap.added_tets);
  ASSERT_EQ(remap.vertex_to_old.size(), after.vertex_count());
  ASSERT_EQ(remap.tet_to_old.size(), after.tet_count());
  std::set<VertexId> alive, of_changed;
  const std::set<TetId> removed(edit.removed.begin(), edit.removed.end());
  for (std::size_t t = 0; t < before.tet_count(); ++t)
    for (const VertexId v : before.tets[t]) (removed.contains(TetId(t)) ? of_changed : alive).insert(v);
  for (const AddedTet& tet : edit.tets)
    for (const VertexId v : tet.vertices)
      if (v.index() < before.vertex_count()) alive.insert(v), of_changed.insert(v);
  std::map<VertexId, Vec3> moved;
  for (const MovedVertex& move : edit.moved) moved[move.vertex] = move.position;
  std::vector<TetId> reshaped;
  for (std::size_t t = 0; t < before.tet_count(); ++t) {
    const Tet& tet = before.tets[t];
    if (removed.contains(TetId(t)) ||
        std::none_of(tet.begin(), tet.end(), [&](VertexId v) { return moved.contains(v); }))
      continue;
    reshaped.emplace_back(t);
    of_changed.insert(tet.begin(), tet.end());
  }
  EXPECT_EQ(remap.reshaped, reshaped);
  EXPECT_EQ(reshaped_tets(before, edit), reshaped);
  ASSERT_EQ(remap.added_from.size(), edit.vertices.size());
  for (std::size_t k = 0; k < edit.vertices.size(); ++k) {
    EXPECT_EQ(remap.added_from[k].from, edit.vertices[k].from);
    EXPECT_EQ(after.position(remap.added_vertices[k]), edit.vertices[k].position);
  }
  ASSERT_EQ(remap.added_parents.size(), edit.tets.size());
  for (std::size_t k = 0; k < edit.tets.size(); ++k) EXPECT_EQ(remap.added_parents[k], edit.tets[k].parent);
  EXPECT_EQ(remap.moved.size(), edit.moved.size());
  std::vector<VertexId> orphaned, touched;
  for (std::size_t v = 0; v < before.vertex_count(); ++v) {
    if (!alive.contains(VertexId(v))) orphaned.emplace_back(v);
    if (alive.contains(VertexId(v)) && of_changed.contains(VertexId(v))) touched.emplace_back(v);
    EXPECT_EQ(remap.vertex_to_new[v].valid(), alive.contains(VertexId(v)));
    if (alive.contains(VertexId(v))) {
      EXPECT_EQ(after.position(remap.vertex_to_new[v]),
                moved.contains(VertexId(v)) ? moved.at(VertexId(v)) : before.positions[v]);
    }
  }
  EXPECT_EQ(remap.orphaned, orphaned);
  EXPECT_EQ(remap.touched, touched);
  for (std::size_t t = 0; t < before.tet_count(); ++t) {
    EXPECT_EQ(remap.tet_to_new[t].valid(), !removed.contains(TetId(t)));
    if (!remap.tet_to_new[t].valid()) continue;
    EXPECT_EQ(after.regions[remap.tet_to_new[t].index()], before.regions[t]);
    for (int c = 0; c < 4; ++c)
      EXPECT_EQ(after.tet(remap.tet_to_new[t])[c], remap.vertex_to_new[before.tets[t][c].index()]);
  }
  const EditExtent extent = extent_of(before, edit);
  EXPECT_EQ(extent.orphaned, orphaned);
  EXPECT_EQ(extent.touched, touched);
}

/// Splits an edge at `weight`: every tet around it becomes two.
TopologyEdit split_edge(const TetMesh& mesh, VertexId a, VertexId b, double weight) {
  TopologyEdit edit;
  edit.vertices.push_back({(1 - weight) * mesh.position(a) + weight * mesh.position(b), a, b, weight});
  const VertexId middle(mesh.vertex_count());
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (std::find(tet.begin(), tet.end(), a) == tet.end() || std::find(tet.begin(), tet.end(), b) == tet.end())
      continue;
    edit.removed.emplace_back(t);
    for (const VertexId end : {a, b}) {
      Tet half = tet;
      std::replace(half.begin(), half.end(), end, middle);
      edit.tets.push_back({half, TetId(t)});
    }
  }
  return edit;
}

/// Detaches the tets on the upper side of z = height from the rest by copying the vertices between them.
TopologyEdit split_along(const TetMesh& mesh, double height) {
  TopologyEdit edit;
  std::vector<VertexId> copy(mesh.vertex_count());
  for (const TetId t : tets_where(mesh, [&](const Vec3& p) { return p.z() > height; })) {
    Tet tet = mesh.tet(t);
    bool changed = false;
    for (VertexId& v : tet) {
      if (std::abs(mesh.position(v).z() - height) > 1e-12) continue;
      if (!copy[v.index()].valid()) {
        copy[v.index()] = VertexId(mesh.vertex_count() + edit.vertices.size());
        edit.vertices.push_back({mesh.position(v), v, v, 0});
      }
      v = copy[v.index()];
      changed = true;
    }
    if (!changed) continue;
    edit.removed.push_back(t);
    edit.tets.push_back({tet, t});
  }
  return edit;
}

TEST(Edit, RandomRemovalsKeepTheMeshSound) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    TetMesh mesh = box_mesh(4, 3, 3, {0.04, 0.03, 0.03}, seed % 2 == 0 ? CubeSplit::six : CubeSplit::five);
    Random random(seed);
    while (mesh.tet_count() > 0) {
      const TetMesh before = mesh;
      TopologyEdit edit;
      edit.removed = random_tets(mesh, 1 + random.below(60), seed);
      double gone = 0;
      for (const TetId t : edit.removed) gone += signed_volume(before, t);
      const Remap remap = apply(mesh, edit);
      expect_consistent(before, mesh, edit, remap);
      EXPECT_NEAR(volume_of(mesh), volume_of(before) - gone, 1e-18);
      ASSERT_EQ(validate(mesh).describe(), "");
      if (HasFailure()) return;
    }
    EXPECT_EQ(mesh.vertex_count(), 0u);
  }
}

TEST(Edit, RandomEdgeSplitsConserveVolumeAndConformity) {
  TetMesh mesh = bar_mesh(4);
  const double volume = volume_of(mesh);
  Random random(7);
  for (int step = 0; step < 60; ++step) {
    const TetMesh before = mesh;
    const Tet& tet = mesh.tets[random.below(mesh.tet_count())];
    const TopologyEdit edit = split_edge(mesh, tet[0], tet[1 + random.below(3)], random.between(0.3, 0.7));
    const Remap remap = apply(mesh, edit);
    expect_consistent(before, mesh, edit, remap);
    EXPECT_TRUE(remap.orphaned.empty());
    ASSERT_EQ(validate(mesh).describe(), "");
    EXPECT_TRUE(check_manifold(boundary_surface(mesh)).closed_manifold());
    EXPECT_NEAR(volume_of(mesh), volume, 1e-12 * volume);
    if (HasFailure()) return;
  }
  EXPECT_EQ(mesh.vertex_count(), bar_mesh(4).vertex_count() + 60);
}

TEST(Edit, EditsOfEveryKindInAnyOrder) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    TetMesh mesh = seed % 2 == 0 ? biliary_mesh() : box_mesh(4, 4, 4, {0.04, 0.04, 0.04}, CubeSplit::five);
    Random random(seed);
    std::size_t moved = 0, added = 0;
    for (int step = 0; step < 30; ++step) {
      const TetMesh before = mesh;
      const TopologyEdit edit = random_edit(mesh, 1 + random.below(10), random.next());
      const Remap remap = apply(mesh, edit);
      expect_consistent(before, mesh, edit, remap);
      ASSERT_FALSE(validate(mesh).fatal()) << validate(mesh).describe();
      if (edit.removed.size() != edit.tets.size() && edit.tets.empty()) continue;
      EXPECT_NEAR(volume_of(mesh), volume_of(before), edit.moved.empty() ? 1e-17 : 0.05 * volume_of(before));
      moved += edit.moved.size();
      added += edit.vertices.size();
      if (HasFailure()) return;
    }
    EXPECT_GT(moved, 5u);
    EXPECT_GT(added, 10u);
  }
}

// All at once: an edge is bisected, one end of it moves, a tet elsewhere goes.
TEST(Edit, RemovesAddsAndMovesTogether) {
  TetMesh mesh = box_mesh(4, 3, 3, {0.04, 0.03, 0.03});
  const TetMesh before = mesh;
  const Tet inner = mesh.tets[mesh.tet_count() / 2];
  TopologyEdit edit = split_edge(mesh, inner[0], inner[1], 0.5);
  std::size_t last = mesh.tet_count() - 1;
  while (std::binary_search(edit.removed.begin(), edit.removed.end(), TetId(last))) --last;
  edit.removed.emplace_back(last);
  std::sort(edit.removed.begin(), edit.removed.end());
  edit.moved.push_back({inner[0], inner[1], 0.1, 0.9 * mesh.position(inner[0]) + 0.1 * mesh.position(inner[1])});
  const Remap remap = apply(mesh, edit);
  expect_consistent(before, mesh, edit, remap);
  EXPECT_FALSE(validate(mesh).fatal());
  EXPECT_FALSE(remap.reshaped.empty());
}

TEST(Edit, AddedTetsInheritTheRegionOfTheirParent) {
  TetMesh mesh = two_tets();
  const TopologyEdit edit = split_edge(mesh, VertexId(0), VertexId(3), 0.5);
  const Remap remap = apply(mesh, edit);
  ASSERT_EQ(mesh.tet_count(), 3u);
  EXPECT_EQ(mesh.regions, (std::vector<std::int32_t>{2, 1, 1}));
  EXPECT_EQ(remap.added_tets, (std::vector<TetId>{TetId(1), TetId(2)}));
}

TEST(Edit, CopiedVerticesPartTheMesh) {
  TetMesh mesh = box_mesh(3, 3, 4, {0.03, 0.03, 0.04});
  const TetMesh before = mesh;
  const TopologyEdit edit = split_along(mesh, 0.02);
  const Remap remap = apply(mesh, edit);
  expect_consistent(before, mesh, edit, remap);
  EXPECT_EQ(edit.vertices.size(), 16u);
  EXPECT_EQ(face_connected_parts(mesh).count(), 2u);
  const MeshProblems problems = validate(mesh);
  EXPECT_FALSE(problems.fatal());
  EXPECT_EQ(problems.coincident.size(), 16u);
  EXPECT_NEAR(volume_of(mesh), volume_of(before), 1e-18);
}

TEST(Edit, VerticesThatNoTetUsedAreDroppedToo) {
  TetMesh mesh = two_tets();
  mesh.positions.insert(mesh.positions.begin(), Vec3(9, 9, 9));
  for (Tet& tet : mesh.tets)
    for (VertexId& v : tet) v = VertexId(v.index() + 1);
  const Remap remap = apply(mesh, TopologyEdit{{TetId(1)}, {}, {}});
  EXPECT_EQ(remap.orphaned, (std::vector<VertexId>{VertexId(0), VertexId(5)}));
  EXPECT_EQ(mesh.vertex_count(), 4u);
}

TEST(Edit, EmptyEditChangesNothing) {
  TetMesh mesh = biliary_mesh();
  const TetMesh before = mesh;
  const TopologyEdit edit;
  EXPECT_TRUE(edit.empty());
  const Remap remap = apply(mesh, edit);
  expect_consistent(before, mesh, edit, remap);
  EXPECT_EQ(mesh.tets, before.tets);
  EXPECT_EQ(mesh.region_names, before.region_names);
}

TEST(Edit, BadEditsAreRefusedAndLeaveTheMeshAlone) {
  TetMesh mesh = two_tets();
  const TetMesh before = mesh;
  const auto refused = [&](const TopologyEdit& edit) {
    EXPECT_THROW(apply(mesh, edit), InputError);
    EXPECT_THROW(extent_of(before, edit), InputError);
    EXPECT_EQ(mesh.tets, before.tets);
    EXPECT_EQ(mesh.positions, before.positions);
  };
  const Tet tet = before.tets[0];
  refused({{TetId(2)}, {}, {}});
  refused({{TetId(1), TetId(0)}, {}, {}});
  refused({{TetId(0), TetId(0)}, {}, {}});
  refused({{}, {}, {{tet, TetId(0)}}});                                        // the parent stays
  refused({{TetId(0)}, {{Vec3::Zero(), VertexId(0), VertexId(1), 0.5}}, {}});  // an unused vertex
  refused({{TetId(0)}, {}, {{{VertexId(0), VertexId(1), VertexId(2), VertexId(5)}, TetId(0)}}});
  refused({{TetId(0)},
           {{Vec3::Zero(), VertexId(7), VertexId(1), 0.5}},
           {{{VertexId(0), VertexId(1), VertexId(2), VertexId(5)}, TetId(0)}}});
  refused({{TetId(0)},
           {{Vec3(0, NAN, 0), VertexId(0), VertexId(1), 0.5}},
           {{{VertexId(0), VertexId(1), VertexId(2), VertexId(5)}, TetId(0)}}});
}

TEST(Edit, BadMovesAndFlatTetsAreRefusedAndLeaveTheMeshAlone) {
  TetMesh mesh = box_mesh(2, 1, 1, {0.02, 0.01, 0.01});
  const TetMesh before = mesh;
  const auto refused = [&](const TopologyEdit& edit) {
    EXPECT_THROW(apply(mesh, edit), InputError);
    EXPECT_THROW(extent_of(before, edit), InputError);
    EXPECT_EQ(mesh.tets, before.tets);
    EXPECT_EQ(mesh.positions, before.positions);
    EXPECT_EQ(mesh.regions, before.regions);
  };
  const auto move = [&](std::size_t v, std::size_t to, double weight) {
    return MovedVertex{VertexId(v), VertexId(to), weight,
                       (1 - weight) * before.positions[v] + weight * before.positions[to]};
  };
  TetMesh fine = before;
  EXPECT_NO_THROW(apply(fine, {{}, {}, {}, {move(0, 1, 0.2), move(3, 0, 0.2)}}));
  refused({{}, {}, {}, {move(3, 0, 0.2), move(0, 1, 0.2)}});              // not ascending
  refused({{}, {}, {}, {move(0, 1, 0.2), move(0, 1, 0.2)}});              // twice
  refused({{}, {}, {}, {move(0, 2, 0.2)}});                               // shares no tet
  refused({{}, {}, {}, {move(0, 0, 0.2)}});                               // goes nowhere
  refused({{}, {}, {}, {{VertexId(12), VertexId(0), 0, Vec3::Zero()}}});  // not there
  refused({{}, {}, {}, {{VertexId(0), VertexId(12), 0, Vec3::Zero()}}});
  refused({{}, {}, {}, {move(0, 1, 1.0)}});  // flat
  refused({{}, {}, {}, {move(0, 1, 1.2)}});  // beyond the edge
  refused({{}, {}, {}, {move(0, 1, -0.1)}});
  MovedVertex wild = move(0, 1, 0.5);
  wild.position = Vec3(0.05, 0.02, 0.03);  // turns a tet inside out
  refused({{}, {}, {}, {wild}});
  wild.position = Vec3(NAN, 0, 0);
  refused({{}, {}, {}, {wild}});
  TopologyEdit gone;
  for (std::size_t t = 0; t < before.tet_count(); ++t)
    if (std::find(before.tets[t].begin(), before.tets[t].end(), VertexId(0)) != before.tets[t].end())
      gone.removed.emplace_back(t);
  gone.moved.push_back(move(0, 1, 0.2));  // does not survive
  refused(gone);
  const Tet& tet = before.tets[0];
  refused({{TetId(0)}, {}, {{{tet[0], tet[2], tet[1], tet[3]}, TetId(0)}}});  // inverted
  refused({{TetId(0)}, {}, {{{tet[0], tet[0], tet[2], tet[3]}, TetId(0)}}});  // a vertex twice: flat
}

TEST(Edit, ExactlyTheSameEveryTime) {
  TetMesh one = biliary_mesh(), two = biliary_mesh();
  const TopologyEdit edit{random_tets(one, 300, 3), {}, {}};
  const Remap a = apply(one, edit), b = apply(two, edit);
  EXPECT_EQ(one.tets, two.tets);
  EXPECT_EQ(one.positions, two.positions);
  EXPECT_EQ(a.vertex_to_new, b.vertex_to_new);
}

}  // namespace
