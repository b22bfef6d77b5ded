// Texture parameters of surfaces, through cuts.
#include "calot/mesh/surface_parameters.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "calot/base/error.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

constexpr double sharpness = 4;

/// What holds for every textured surface.
void expect_sound(const TexturedSurface& s) {
  const std::size_t n = s.surface.positions.size();
  ASSERT_EQ(s.rest.size(), n);
  ASSERT_EQ(s.normals.size(), n);
  ASSERT_EQ(s.weights.size(), n);
  ASSERT_EQ(s.exposed.size(), s.surface.triangles.size());
  for (std::size_t v = 0; v < n; ++v) {
    EXPECT_NEAR(s.normals[v].norm(), 1, 1e-12);
    EXPECT_NEAR(s.weights[v].sum(), 1, 1e-12);
    EXPECT_GE(s.weights[v].minCoeff(), 0);
    EXPECT_EQ(s.rest[v], s.surface.positions[v]);
    const Vec3 expected = s.normals[v].cwiseAbs().array().pow(sharpness);
    EXPECT_LT((s.weights[v] - expected / expected.sum()).norm(), 1e-9);
  }
}

/// Of the mesh's vertices that are on the surface: its number there.
std::map<VertexId, std::size_t> numbers(const Surface& surface) {
  std::map<VertexId, std::size_t> result;
  for (std::size_t v = 0; v < surface.vertex_of_mesh.size(); ++v) result[surface.vertex_of_mesh[v]] = v;
  return result;
}

/// Vertices that stay have exactly what they had. @return how many they are
std::size_t expect_kept(const TexturedSurface& before, const TexturedSurface& after, const Remap& remap) {
  const auto old = numbers(before.surface), now = numbers(after.surface);
  std::size_t kept = 0;
  for (const auto& [vertex, v] : old) {
    const VertexId moved = remap.vertex_to_new[vertex.index()];
    if (!moved.valid() || !now.contains(moved)) continue;
    const std::size_t w = now.at(moved);
    EXPECT_EQ(before.rest[v], after.rest[w]);
    EXPECT_EQ(before.normals[v], after.normals[w]);
    EXPECT_EQ(before.weights[v], after.weights[w]);
    ++kept;
  }
  return kept;
}

/// Whether all corners of a face lie on one side of the box [0, size].
bool on_box(const Surface& surface, const Triangle& t, const Vec3& size) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {0.0, size[axis]})
      if (std::all_of(t.begin(), t.end(),
                      [&](std::uint32_t v) { return std::abs(surface.positions[v][axis] - side) < 1e-12; }))
        return true;
  return false;
}

double exposed_area(const TexturedSurface& s) {
  double area = 0;
  for (std::size_t f = 0; f < s.exposed.size(); ++f) {
    const auto& [a, b, c] = s.surface.triangles[f];
    const auto& p = s.surface.positions;
    if (s.exposed[f] != 0) area += (p[b] - p[a]).cross(p[c] - p[a]).norm() / 2;
  }
  return area;
}

/// Halves a mesh at z = height, which no vertex lies on: edges that cross get two vertices (one for each side) and
/// every crossed tet is made anew from its pieces.
TopologyEdit split_through(const TetMesh& mesh, double height) {
  TopologyEdit edit;
  std::map<std::tuple<VertexId, VertexId, bool>, VertexId> made;
  const auto upper = [&](VertexId v) { return mesh.position(v).z() > height; };
  const auto middle = [&](VertexId a, VertexId b, bool side) {
    if (b < a) std::swap(a, b);
    const auto [at, fresh] = made.try_emplace({a, b, side}, VertexId(mesh.vertex_count() + edit.vertices.size()));
    if (fresh) {
      const double weight = (height - mesh.position(a).z()) / (mesh.position(b).z() - mesh.position(a).z());
      edit.vertices.push_back({(1 - weight) * mesh.position(a) + weight * mesh.position(b), a, b, weight});
    }
    return at->second;
  };
  const auto position = [&](VertexId v) {
    return v.index() < mesh.vertex_count() ? mesh.position(v) : edit.vertices[v.index() - mesh.vertex_count()].position;
  };
  const auto add = [&](Tet tet, std::size_t parent) {
    if (signed_volume(position(tet[0]), position(tet[1]), position(tet[2]), position(tet[3])) < 0)
      std::swap(tet[2], tet[3]);
    edit.tets.push_back({tet, TetId(parent)});
  };
  // A wedge with triangles (a, b, c) and (d, e, f); its quads are cut from their lowest number, so that neighbours fit.
  const auto add_wedge = [&](std::array<VertexId, 6> w, std::size_t parent) {
    const auto lowest = static_cast<std::size_t>(std::min_element(w.begin(), w.end()) - w.begin());
    if (lowest >= 3) w = {w[3], w[4], w[5], w[0], w[1], w[2]};
    std::rotate(w.begin(), w.begin() + static_cast<std::ptrdiff_t>(lowest % 3), w.begin() + 3);
    std::rotate(w.begin() + 3, w.begin() + 3 + static_cast<std::ptrdiff_t>(lowest % 3), w.end());
    add({w[0], w[3], w[4], w[5]}, parent);
    if (std::min(w[1], w[5]) < std::min(w[2], w[4]))
      add({w[0], w[1], w[2], w[5]}, parent), add({w[0], w[1], w[5], w[4]}, parent);
    else
      add({w[0], w[1], w[2], w[4]}, parent), add({w[0], w[4], w[2], w[5]}, parent);
  };
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    std::vector<VertexId> up, down;
    for (const VertexId v : mesh.tets[t]) (upper(v) ? up : down).push_back(v);
    if (up.empty() || down.empty()) continue;
    edit.removed.emplace_back(t);
    for (const bool side : {true, false}) {
      const auto& own = side ? up : down;
      const auto& other = side ? down : up;
      const auto m = [&](std::size_t i, std::size_t j) { return middle(own[i], other[j], side); };
      if (own.size() == 1) add({own[0], m(0, 0), m(0, 1), m(0, 2)}, t);
      if (own.size() == 2) add_wedge({own[0], m(0, 0), m(0, 1), own[1], m(1, 0), m(1, 1)}, t);
      if (own.size() == 3) add_wedge({own[0], own[1], own[2], m(0, 0), m(1, 0), m(2, 0)}, t);
    }
  }
  return edit;
}

/// Parts the tets above a plane of vertices from those below, by copies.
TopologyEdit split_along(const TetMesh& mesh, double height) {
  TopologyEdit edit;
  std::map<VertexId, VertexId> copy;
  for (const TetId t : tets_where(mesh, [&](const Vec3& p) { return p.z() > height; })) {
    Tet tet = mesh.tet(t);
    for (VertexId& v : tet) {
      if (std::abs(mesh.position(v).z() - height) > 1e-12) continue;
      const auto [at, fresh] = copy.try_emplace(v, VertexId(mesh.vertex_count() + edit.vertices.size()));
      if (fresh) edit.vertices.push_back({mesh.position(v), v, v, 0});
      v = at->second;
    }
    if (tet == mesh.tet(t)) continue;
    edit.removed.push_back(t);
    edit.tets.push_back({tet, t});
  }
  return edit;
}

TEST(SurfaceParameters, AFlatSideTakesOneProjectionAndABallAllThree) {
  const TexturedSurface box = textured_surface(box_mesh(4, 4, 4, {1, 1, 1}), 0, sharpness);
  expect_sound(box);
  for (std::size_t v = 0; v < box.rest.size(); ++v) {
    const Vec3 p = box.rest[v];
    if (p.x() == 0 && p.y() > 0 && p.y() < 1 && p.z() > 0 && p.z() < 1) {
      EXPECT_LT((box.normals[v] - Vec3(-1, 0, 0)).norm(), 1e-12);
      EXPECT_LT((box.weights[v] - Vec3(1, 0, 0)).norm(), 1e-12);
    }
  }
  EXPECT_EQ(std::count(box.exposed.begin(), box.exposed.end(), 0), std::ssize(box.exposed));
}

TEST(SurfaceParameters, ARegionHasItsOwnSurface) {
  const TetMesh mesh = bar_mesh(6);
  const TexturedSurface near = textured_surface(mesh, 1, sharpness);
  expect_sound(near);
  for (const Vec3& p : near.rest) EXPECT_LE(p.x(), 0.05 + 1e-12);
  EXPECT_EQ(near.surface.triangles, region_surface(mesh, 1).triangles);
}

TEST(SurfaceParameters, RemovalFlagsExactlyTheFacesThatWereInside) {
  const Vec3 size{0.04, 0.03, 0.03};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    TetMesh mesh = box_mesh(4, 3, 3, size);
    TexturedSurface surface = textured_surface(mesh, 0, sharpness);
    for (int step = 0; step < 4; ++step) {
      const Remap remap =
          apply(mesh, TopologyEdit{random_tets(mesh, 25, seed + 100u * static_cast<unsigned>(step)), {}, {}});
      const TexturedSurface after = after_edit(surface, mesh, remap, 0, sharpness);
      expect_sound(after);
      EXPECT_GT(expect_kept(surface, after, remap), 20u);
      EXPECT_EQ(after.surface.triangles, boundary_surface(mesh).triangles);
      for (std::size_t f = 0; f < after.exposed.size(); ++f)
        EXPECT_EQ(after.exposed[f] == 0, on_box(after.surface, after.surface.triangles[f], size));
      surface = after;
    }
  }
}

TEST(SurfaceParameters, CopiesHaveWhatTheirOriginalsHave) {
  const Vec3 size{0.03, 0.03, 0.04};
  TetMesh mesh = box_mesh(3, 3, 4, size);
  const TexturedSurface before = textured_surface(mesh, 0, sharpness);
  const TopologyEdit edit = split_along(mesh, 0.02);
  const std::size_t old_count = mesh.vertex_count();
  const Remap remap = apply(mesh, edit);
  const TexturedSurface after = after_edit(before, mesh, remap, 0, sharpness);
  expect_sound(after);
  EXPECT_EQ(expect_kept(before, after, remap), before.rest.size());
  const auto old = numbers(before.surface), now = numbers(after.surface);
  std::size_t copies = 0;
  for (std::size_t k = 0; k < edit.vertices.size(); ++k) {
    const auto original = old.find(edit.vertices[k].from);
    if (original == old.end()) continue;  // was inside
    const std::size_t copy = now.at(remap.added_vertices[k]);
    EXPECT_EQ(after.normals[copy], before.normals[original->second]);
    EXPECT_EQ(after.weights[copy], before.weights[original->second]);
    ++copies;
  }
  EXPECT_EQ(copies, 12u);
  ASSERT_LT(old_count, mesh.vertex_count());
  for (std::size_t f = 0; f < after.exposed.size(); ++f)
    EXPECT_EQ(after.exposed[f] == 0, on_box(after.surface, after.surface.triangles[f], size));
  EXPECT_NEAR(exposed_area(after), 2 * 0.03 * 0.03, 1e-12);
  // The four inner vertices of the cut look along z, one side down and one up.
  int up = 0, down = 0;
  for (std::size_t v = 0; v < after.rest.size(); ++v)
    if (after.rest[v].z() == 0.02 && after.rest[v].head<2>().minCoeff() > 0.005 &&
        after.rest[v].head<2>().maxCoeff() < 0.025 && std::abs(after.normals[v].z()) > 1 - 1e-9)
      ++(after.normals[v].z() > 0 ? up : down);
  EXPECT_EQ(up, 4);
  EXPECT_EQ(down, 4);
}

// A vertex that slides along the surface stays on it: its place is the new one, its normal what the surface has there.
TEST(SurfaceParameters, AMovedVertexTakesWhatTheSurfaceHasAtItsNewPlace) {
  const Vec3 size{0.04, 0.04, 0.04};
  TetMesh mesh = box_mesh(4, 4, 4, size);
  const auto number = [](int i, int j, int k) { return VertexId(i + 5 * (j + 5 * k)); };
  const TexturedSurface before = textured_surface(mesh, 0, sharpness);
  const auto old = numbers(before.surface);
  TopologyEdit edit;
  const auto move = [&](VertexId v, VertexId to, double weight) {
    edit.moved.push_back({v, to, weight, (1 - weight) * mesh.position(v) + weight * mesh.position(to)});
  };
  move(number(1, 0, 0), number(2, 0, 0), 0.4);  // along an edge of the box
  move(number(2, 2, 0), number(3, 2, 0), 0.3);  // on a side
  move(number(2, 2, 2), number(3, 2, 2), 0.2);  // inside
  move(number(2, 2, 4), number(2, 2, 3), 0.2);  // off the surface: a dent
  std::vector<VertexId> vertices;
  for (const MovedVertex& moved : edit.moved) vertices.push_back(moved.vertex);
  const Remap remap = apply(mesh, edit);
  const TexturedSurface after = after_edit(before, mesh, remap, 0, sharpness);
  expect_sound(after);
  const auto now = numbers(after.surface);
  EXPECT_EQ(std::count(after.exposed.begin(), after.exposed.end(), 1), 0);
  EXPECT_EQ(now.size(), old.size());
  EXPECT_LT((after.normals[now.at(vertices[1])] - Vec3(0, 0, -1)).norm(), 1e-12);
  EXPECT_EQ(after.rest[now.at(vertices[1])], edit.moved[1].position);
  const Vec3 between = 0.6 * before.normals[old.at(vertices[0])] + 0.4 * before.normals[old.at(edit.moved[0].to)];
  EXPECT_LT((after.normals[now.at(vertices[0])] - between.normalized()).norm(), 1e-12);
  EXPECT_EQ(after.rest[now.at(vertices[0])], edit.moved[0].position);
  EXPECT_FALSE(now.contains(vertices[2]));
  const TexturedSurface bare = textured_surface(mesh, 0, sharpness);
  EXPECT_EQ(after.normals[now.at(vertices[3])], bare.normals[now.at(vertices[3])]);
  for (const auto& [vertex, v] : old)
    if (std::find(vertices.begin(), vertices.end(), vertex) == vertices.end()) {
      EXPECT_EQ(before.normals[v], after.normals[now.at(vertex)]);
    }
}

// A blade takes a vertex along and splits the faces beside it in the same edit.
TEST(SurfaceParameters, PiecesOfAFaceWithAMovedCornerStayUnflagged) {
  const Vec3 size{0.04, 0.04, 0.04};
  TetMesh mesh = box_mesh(4, 4, 4, size);
  const TexturedSurface before = textured_surface(mesh, 0, sharpness);
  const VertexId middle(2 + 5 * 2), right(3 + 5 * 2), left(1 + 5 * 2);
  TopologyEdit edit;
  const Vec3 place = 0.7 * mesh.position(middle) + 0.3 * mesh.position(right);
  edit.moved.push_back({middle, right, 0.3, place});
  edit.vertices.push_back({0.5 * place + 0.5 * mesh.position(left), middle, left, 0.5});
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (std::find(tet.begin(), tet.end(), middle) == tet.end() || std::find(tet.begin(), tet.end(), left) == tet.end())
      continue;
    edit.removed.emplace_back(t);
    for (const VertexId end : {middle, left}) {
      Tet half = tet;
      std::replace(half.begin(), half.end(), end, VertexId(mesh.vertex_count()));
      edit.tets.push_back({half, TetId(t)});
    }
  }
  const Remap remap = apply(mesh, edit);
  const TexturedSurface after = after_edit(before, mesh, remap, 0, sharpness);
  expect_sound(after);
  EXPECT_EQ(std::count(after.exposed.begin(), after.exposed.end(), 1), 0);
  const auto now = numbers(after.surface);
  EXPECT_LT((after.normals[now.at(remap.added_vertices[0])] - Vec3(0, 0, -1)).norm(), 1e-12);
}

TEST(SurfaceParameters, PiecesOfASplitFaceStayUnflagged) {
  const Vec3 size{0.03, 0.03, 0.04};
  TetMesh mesh = box_mesh(3, 3, 4, size, CubeSplit::five);
  const TexturedSurface before = textured_surface(mesh, 0, sharpness);
  const Remap remap = apply(mesh, split_through(mesh, 0.0163));
  const TexturedSurface after = after_edit(before, mesh, remap, 0, sharpness);
  expect_sound(after);
  EXPECT_EQ(expect_kept(before, after, remap), before.rest.size());
  for (std::size_t f = 0; f < after.exposed.size(); ++f)
    EXPECT_EQ(after.exposed[f] == 0, on_box(after.surface, after.surface.triangles[f], size));
  EXPECT_NEAR(exposed_area(after), 2 * 0.03 * 0.03, 1e-9);
  // New vertices on a flat side look the way the side looks.
  std::size_t on_side = 0;
  for (std::size_t v = 0; v < after.rest.size(); ++v) {
    const Vec3 p = after.rest[v];
    if (std::abs(p.z() - 0.0163) > 1e-9 || p.x() != 0 || p.y() < 0.011 || p.y() > 0.019) continue;
    EXPECT_GT(after.normals[v].dot(Vec3(-1, 0, 0)), 0.999);
    ++on_side;
  }
  EXPECT_GT(on_side, 0u);
}

TEST(SurfaceParameters, SeveralEditsInARow) {
  const Vec3 size{0.04, 0.03, 0.04};
  TetMesh mesh = box_mesh(4, 3, 4, size);
  TexturedSurface surface = textured_surface(mesh, 0, sharpness);
  const std::map<VertexId, std::size_t> first = numbers(surface.surface);
  const TexturedSurface original = surface;
  std::vector<VertexId> where;  // today's number of each first vertex
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) where.emplace_back(v);
  const auto step = [&](const TopologyEdit& edit) {
    const Remap remap = apply(mesh, edit);
    for (VertexId& v : where)
      if (v.valid()) v = remap.vertex_to_new[v.index()];
    const TexturedSurface after = after_edit(surface, mesh, remap, 0, sharpness);
    expect_sound(after);
    expect_kept(surface, after, remap);
    for (std::size_t f = 0; f < after.exposed.size(); ++f)
      EXPECT_EQ(after.exposed[f] == 0, on_box(after.surface, after.surface.triangles[f], size));
    surface = after;
  };
  step(split_through(mesh, 0.0133));
  step(TopologyEdit{random_tets(mesh, 30, 5), {}, {}});
  step(split_along(mesh, 0.03));
  step(split_through(mesh, 0.0261));
  step(TopologyEdit{random_tets(mesh, 40, 6), {}, {}});
  const auto now = numbers(surface.surface);
  std::size_t still_there = 0;
  for (const auto& [vertex, v] : first) {
    const VertexId today = where[vertex.index()];
    if (!today.valid() || !now.contains(today)) continue;
    EXPECT_EQ(surface.normals[now.at(today)], original.normals[v]);
    EXPECT_EQ(surface.weights[now.at(today)], original.weights[v]);
    ++still_there;
  }
  EXPECT_GT(still_there, 40u);
}

TEST(SurfaceParameters, RegionsThatPartShowTheFaceThatWasBetweenThem) {
  TetMesh mesh = cell_mesh(2, 2, 4, {0.02, 0.02, 0.04}, [](int, int, int k) { return k < 2 ? 1 : 2; });
  const TexturedSurface before = textured_surface(mesh, 1, sharpness);
  const Remap remap = apply(mesh, split_along(mesh, 0.02));
  const TexturedSurface after = after_edit(before, mesh, remap, 1, sharpness);
  expect_sound(after);
  EXPECT_EQ(std::count(after.exposed.begin(), after.exposed.end(), 1), 0);
  EXPECT_EQ(expect_kept(before, after, remap), before.rest.size());
}

TEST(SurfaceParameters, NothingLeftOfARegion) {
  TetMesh mesh = two_tets();
  const TexturedSurface before = textured_surface(mesh, 1, sharpness);
  const Remap remap = apply(mesh, TopologyEdit{{TetId(0)}, {}, {}});
  const TexturedSurface after = after_edit(before, mesh, remap, 1, sharpness);
  EXPECT_TRUE(after.rest.empty());
  EXPECT_TRUE(after.exposed.empty());
}

TEST(SurfaceParameters, ASharpnessBelowOneIsRefused) {
  EXPECT_THROW(textured_surface(two_tets(), 0, 0.5), InputError);
  EXPECT_THROW(textured_surface(two_tets(), 0, NAN), InputError);
}

}  // namespace
