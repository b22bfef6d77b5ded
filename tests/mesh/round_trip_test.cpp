// What is written reads back bit for bit, in every format, and is the same file every time.
#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

struct VolumeCase {
  MeshFormat format;
  const char* ending;
  const char* name;
};

void PrintTo(const VolumeCase& c, std::ostream* out) {
  *out << c.name;
}

class VolumeRoundTrip : public testing::TestWithParam<VolumeCase> {};

const VolumeCase volume_cases[] = {
    {MeshFormat::msh22, ".msh", "msh22"},
    {MeshFormat::msh22_binary, ".msh", "msh22_binary"},
    {MeshFormat::msh41, ".msh", "msh41"},
    {MeshFormat::msh41_binary, ".msh", "msh41_binary"},
    {MeshFormat::vtu_ascii, ".vtu", "vtu_ascii"},
    {MeshFormat::vtu_base64, ".vtu", "vtu_base64"},
    {MeshFormat::vtu_appended, ".vtu", "vtu_appended"},
    {MeshFormat::vtu_zlib, ".vtu", "vtu_zlib"},
    {MeshFormat::vtk_ascii, ".vtk", "vtk_ascii"},
    {MeshFormat::vtk_binary, ".vtk", "vtk_binary"},
};

INSTANTIATE_TEST_SUITE_P(Formats, VolumeRoundTrip, testing::ValuesIn(volume_cases),
                         [](const auto& param) { return param.param.name; });

void expect_same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t v = 0; v < a.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a[v][axis]), std::bit_cast<std::uint64_t>(b[v][axis])) << v;
}

void expect_same(const TetMesh& a, const TetMesh& b) {
  expect_same_bits(a.positions, b.positions);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.regions, b.regions);
  EXPECT_EQ(a.region_names, b.region_names);
}

/// Coordinates that are hard to write: no short decimal, huge, tiny, denormal, −0.
TetMesh awkward_mesh() {
  TetMesh mesh = biliary_mesh();
  Random random(11);
  for (Vec3& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] += 1e-5 * random.unit();
  mesh.positions.insert(
      mesh.positions.end(),
      {{1e90, -1e-300, std::numeric_limits<double>::denorm_min()}, {-0.0, 1.0 / 3, -1e99}, {0.1, 0.2, 0.3}});
  mesh.regions[0] = std::numeric_limits<std::int32_t>::max();
  mesh.regions[1] = -5;
  mesh.regions[2] = 0;
  mesh.region_names[7] = "named, though no tet has it: Gallenblase & <Gänge> %20";
  return mesh;
}

TEST_P(VolumeRoundTrip, BitForBit) {
  const TempFolder folder;
  for (const TetMesh& mesh :
       {awkward_mesh(), biliary_mesh(2), regular_tet(), box_mesh(2, 2, 2, {1, 1, 1}, CubeSplit::five)}) {
    const auto path = folder / (std::string("mesh") + GetParam().ending);
    write_mesh(path, mesh, GetParam().format);
    expect_same(read_mesh(path).mesh, mesh);
  }
}

TEST_P(VolumeRoundTrip, SameBytesEveryTime) {
  const TempFolder folder;
  const TetMesh mesh = awkward_mesh();
  write_mesh(folder / (std::string("a") + GetParam().ending), mesh, GetParam().format);
  write_mesh(folder / (std::string("b") + GetParam().ending), mesh, GetParam().format);
  EXPECT_EQ(read_bytes(folder / (std::string("a") + GetParam().ending)),
            read_bytes(folder / (std::string("b") + GetParam().ending)));
}

TEST_P(VolumeRoundTrip, ArraysRideAlong) {
  const TempFolder folder;
  const TetMesh mesh = biliary_mesh();
  std::vector<VertexArray> arrays{{"displacement of it", 3, {}}, {"temperature", 1, {}}};
  for (std::size_t i = 0; i < 3 * mesh.vertex_count(); ++i) arrays[0].values.push_back(1.0 / double(i + 1));
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) arrays[1].values.push_back(i == 5 ? NAN : 37.0);
  const auto path = folder / (std::string("mesh") + GetParam().ending);
  write_mesh(path, mesh, GetParam().format, arrays);
  expect_same(read_mesh(path).mesh, mesh);
}

TEST_P(VolumeRoundTrip, ScaleIsAppliedOnce) {
  const TempFolder folder;
  const TetMesh mesh = box_mesh(2, 2, 2, {8, 8, 8});
  const auto path = folder / (std::string("mesh") + GetParam().ending);
  write_mesh(path, mesh, GetParam().format);
  EXPECT_DOUBLE_EQ(quality(read_mesh(path, 1e-3).mesh).volume, 512e-9);
  for (const double scale : {0.0, -1.0, double(NAN), double(INFINITY)})
    EXPECT_THROW(read_mesh(path, scale), InputError);
}

TEST_P(VolumeRoundTrip, AMeshWoundTheOtherWayIsTurned) {
  const TempFolder folder;
  TetMesh mesh = box_mesh(2, 2, 2, {1, 1, 1});
  for (Tet& tet : mesh.tets) std::swap(tet[2], tet[3]);
  const auto path = folder / (std::string("mesh") + GetParam().ending);
  write_mesh(path, mesh, GetParam().format);
  const MeshFile file = read_mesh(path);
  EXPECT_EQ(file.mesh.tets, box_mesh(2, 2, 2, {1, 1, 1}).tets);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("all 48 tets"), std::string::npos);
}

TEST_P(VolumeRoundTrip, UnusedVerticesAreKeptAndNoted) {
  const TempFolder folder;
  TetMesh mesh = two_tets();
  mesh.positions.emplace_back(4, 4, 4);
  const auto path = folder / (std::string("mesh") + GetParam().ending);
  write_mesh(path, mesh, GetParam().format);
  const MeshFile file = read_mesh(path);
  expect_same(file.mesh, mesh);
  EXPECT_EQ(file.notes, std::vector<std::string>{"1 vertices that no tet uses kept"});
}

/// Cubes that meet in the plane x = 1, every vertex there doubled, as a cut leaves them.
TetMesh parted_cubes() {
  TetMesh mesh = box_mesh(2, 1, 1, {2, 1, 1});
  const std::size_t n = mesh.vertex_count();
  std::vector<VertexId> copy(n);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    double middle = 0;
    for (const VertexId v : mesh.tets[t]) middle += mesh.position(v).x() / 4;
    for (VertexId& v : mesh.tets[t]) {
      if (middle < 1 || mesh.position(v).x() != 1) continue;
      if (!copy[v.index()].valid()) {
        copy[v.index()] = VertexId(mesh.vertex_count());
        mesh.positions.push_back(Vec3(mesh.position(v)));
      }
      v = copy[v.index()];
    }
  }
  return mesh;
}

TEST_P(VolumeRoundTrip, ACutMeshStaysCut) {
  const TempFolder folder;
  TetMesh mesh = parted_cubes();
  ASSERT_EQ(face_connected_parts(mesh).count(), 2u);
  const auto path = folder / (std::string("mesh") + GetParam().ending);
  write_mesh(path, mesh, GetParam().format);
  const MeshFile file = read_mesh(path);
  expect_same(file.mesh, mesh);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_TRUE(file.notes[0].starts_with("4 vertices are at exactly the place of an earlier one")) << file.notes[0];
  // A vertex that no tet uses parts nothing, wherever it is.
  mesh.positions.push_back(mesh.positions[0]);
  write_mesh(path, mesh, GetParam().format);
  const MeshFile more = read_mesh(path);
  ASSERT_EQ(more.notes.size(), 2u);
  EXPECT_EQ(more.notes[1], file.notes[0]);
}

TEST(Writing, ByEnding) {
  const TempFolder folder;
  const TetMesh mesh = biliary_mesh();
  write_mesh(folder / "a.MSH", mesh);
  EXPECT_TRUE(read_bytes(folder / "a.MSH").starts_with("$MeshFormat\n2.2 0 8\n"));
  write_mesh(folder / "a.vtu", mesh);
  EXPECT_NE(read_bytes(folder / "a.vtu").find("vtkZLibDataCompressor"), std::string::npos);
  write_mesh(folder / "a.vtk", mesh);
  EXPECT_NE(read_bytes(folder / "a.vtk").find("\nBINARY\n"), std::string::npos);
  for (const char* name : {"a.MSH", "a.vtu", "a.vtk"}) expect_same(read_mesh(folder / name).mesh, mesh);
  EXPECT_THROW(write_mesh(folder / "a.stl", mesh), InputError);
  EXPECT_THROW(write_mesh(folder / "a", mesh), InputError);
}

TEST(Writing, WhatCantBeWrittenIsRefusedAndLeavesNothing) {
  const TempFolder folder;
  const auto refused = [&](const TetMesh& mesh, const std::vector<VertexArray>& arrays = {}) {
    EXPECT_THROW(write_mesh(folder / "bad.msh", mesh, arrays), InputError);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  };
  refused({});
  TetMesh mesh = two_tets();
  mesh.regions.pop_back();
  refused(mesh);
  mesh = two_tets();
  mesh.positions[0].x() = NAN;
  refused(mesh);
  mesh = two_tets();
  mesh.tets[0][0] = VertexId(9);
  refused(mesh);
  mesh = two_tets();
  mesh.region_names[1] = "quote \" inside";
  refused(mesh);
  mesh.region_names[1] = "line\nend";
  refused(mesh);
  refused(two_tets(), {{"short", 1, {1, 2}}});
  refused(two_tets(), {{"", 1, {1, 2, 3, 4, 5}}});
  refused(two_tets(), {{"pairs", 2, std::vector<double>(10)}});
  refused(two_tets(), {{"none", 0, {}}});
  EXPECT_THROW(write_mesh(folder / "no" / "such" / "folder.msh", two_tets()), FailedError);
}

struct SurfaceCase {
  SurfaceFormat format;
  const char* ending;
  const char* name;
  bool regions;
};

void PrintTo(const SurfaceCase& c, std::ostream* out) {
  *out << c.name;
}

class SurfaceRoundTrip : public testing::TestWithParam<SurfaceCase> {};

const SurfaceCase surface_cases[] = {
    {SurfaceFormat::stl_ascii, ".stl", "stl_ascii", false},
    {SurfaceFormat::stl_binary, ".stl", "stl_binary", false},
    {SurfaceFormat::obj, ".obj", "obj", true},
    {SurfaceFormat::ply_ascii, ".ply", "ply_ascii", true},
    {SurfaceFormat::ply_binary, ".ply", "ply_binary", true},
};

INSTANTIATE_TEST_SUITE_P(Formats, SurfaceRoundTrip, testing::ValuesIn(surface_cases),
                         [](const auto& param) { return param.param.name; });

/// Corner positions of all triangles, in order: the same for a surface and for its triangle soup.
std::vector<Vec3> corners_of(const Surface& surface) {
  std::vector<Vec3> corners;
  for (const Triangle& t : surface.triangles)
    for (const std::uint32_t v : t) corners.push_back(surface.positions[v]);
  return corners;
}

/// Through memory: GCC 12.2 at -O2 takes a vectorised double → float → double in place for nothing to do.
void round_to_float(Surface& surface) {
  for (Vec3& p : surface.positions)
    for (int axis = 0; axis < 3; ++axis) {
      const volatile auto narrow = static_cast<float>(p[axis]);
      p[axis] = narrow;
    }
}

TEST_P(SurfaceRoundTrip, BitForBit) {
  const TempFolder folder;
  Surface surface = boundary_surface(biliary_mesh());
  if (GetParam().format == SurfaceFormat::stl_binary) round_to_float(surface);  // all that it holds
  const auto path = folder / (std::string("surface") + GetParam().ending);
  write_surface(path, surface, GetParam().format);
  const Surface back = read_surface(path);
  expect_same_bits(corners_of(back), corners_of(surface));
  EXPECT_TRUE(check_manifold(back).closed_manifold());
  EXPECT_EQ(back.positions.size(), surface.positions.size());
  if (GetParam().regions) {  // .stl numbers its vertices anew
    EXPECT_EQ(back.triangles, surface.triangles);
  }
  EXPECT_EQ(back.regions, GetParam().regions ? surface.regions : std::vector<std::int32_t>{});
  const Surface scaled = read_surface(path, 1e-3);
  EXPECT_EQ(scaled.positions[5], back.positions[5] * 1e-3);
  EXPECT_THROW(read_surface(path, 0), InputError);
}

TEST_P(SurfaceRoundTrip, WithoutRegions) {
  const TempFolder folder;
  Surface surface = boundary_surface(regular_tet());
  surface.regions.clear();
  const auto path = folder / (std::string("surface") + GetParam().ending);
  write_surface(path, surface, GetParam().format);
  EXPECT_TRUE(read_surface(path).regions.empty());
}

TEST(Writing, SurfacesByEnding) {
  const TempFolder folder;
  const Surface surface = boundary_surface(regular_tet());
  for (const char* name : {"a.stl", "a.obj", "a.PLY"}) {
    write_surface(folder / name, surface);
    EXPECT_EQ(read_surface(folder / name).triangles.size(), 4u);
  }
  EXPECT_EQ(read_bytes(folder / "a.stl").size(), 84u + 4 * 50);
  EXPECT_THROW(write_surface(folder / "a.msh", surface), InputError);
  EXPECT_THROW(read_surface(folder / "a.msh"), InputError);
  Surface bad = surface;
  bad.triangles[0][0] = 44;
  EXPECT_THROW(write_surface(folder / "bad.obj", bad), InputError);
  bad = surface;
  bad.regions.pop_back();
  EXPECT_THROW(write_surface(folder / "bad.obj", bad), InputError);
  bad = surface;
  bad.positions[0].x() = 1e60;
  EXPECT_THROW(write_surface(folder / "bad.stl", bad), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "bad.stl"));
}

}  // namespace
