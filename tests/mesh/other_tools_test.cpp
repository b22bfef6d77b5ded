// Files that other programs wrote, and other programs reading ours. Needs gmsh and python3-meshio.
#include <gtest/gtest.h>

#include "calot/mesh/mesh_file.h"
#include "calot/mesh/quality.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

using namespace calot;
using namespace calot::test;

namespace {

void run_or_fail(const std::string& command) {
  const CommandResult result = run_command(command);
  ASSERT_EQ(result.status, 0) << command << "\n" << result.output;
}

// ---- Gmsh

// Two boxes side by side that share a face; the second scaled so that the whole holds 3 cubic units.
const char* const two_boxes = R"(
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {1, 0, 0, 2, 1, 1};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Mesh.CharacteristicLengthMax = 0.5;
)";
const char* const groups = R"(
Physical Volume("left", 4) = {1};
Physical Volume("right part", 7) = {2};
Physical Surface("not a volume", 4) = {1};
)";

void expect_two_boxes(const MeshFile& file, std::int32_t left, std::int32_t right) {
  EXPECT_GT(file.mesh.tet_count(), 50u);
  EXPECT_NEAR(quality(file.mesh).volume, 3, 1e-12);
  EXPECT_NEAR(quality(file.mesh, left).volume, 1, 1e-12);
  EXPECT_NEAR(quality(file.mesh, right).volume, 2, 1e-12);
  EXPECT_TRUE(check_manifold(boundary_surface(file.mesh)).closed_manifold());
}

class FromGmsh : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Formats, FromGmsh,
                         testing::Values("-format msh22", "-format msh22 -bin", "-format msh41", "-format msh41 -bin"));

TEST_P(FromGmsh, PhysicalGroupsAreRegions) {
  const TempFolder folder;
  write_bytes(folder / "box.geo", std::string(two_boxes) + groups);
  const auto mesh = folder / "box.msh";
  run_or_fail("gmsh -3 " + (folder / "box.geo").string() + " " + GetParam() + " -o " + mesh.string());
  const MeshFile file = read_mesh(mesh);
  expect_two_boxes(file, 4, 7);
  EXPECT_EQ(file.mesh.region_names, (std::map<std::int32_t, std::string>{{4, "left"}, {7, "right part"}}));
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("triangles ignored"), std::string::npos);
}

TEST_P(FromGmsh, EntitiesAreRegionsWithoutGroups) {
  const TempFolder folder;
  write_bytes(folder / "box.geo", two_boxes);
  const auto mesh = folder / "box.msh";
  run_or_fail("gmsh -3 " + (folder / "box.geo").string() + " " + GetParam() + " -o " + mesh.string());
  const MeshFile file = read_mesh(mesh);
  expect_two_boxes(file, 1, 2);
  EXPECT_TRUE(file.mesh.region_names.empty());
  EXPECT_EQ(file.notes.size(), 3u);  // lines, points, triangles
}

TEST_P(FromGmsh, NodesOfGroupedVolumesMayLeaveGapsInNumbers) {
  const TempFolder folder;
  write_bytes(folder / "box.geo", std::string(two_boxes) + "Physical Volume(\"right\", 2) = {2};\n");
  const auto mesh = folder / "box.msh";
  run_or_fail("gmsh -3 " + (folder / "box.geo").string() + " " + GetParam() + " -o " + mesh.string());
  EXPECT_NEAR(quality(read_mesh(mesh).mesh).volume, 2, 1e-12);
}

TEST_P(FromGmsh, SecondOrderIsRefused) {
  const TempFolder folder;
  write_bytes(folder / "box.geo", std::string(two_boxes) + groups);
  const auto mesh = folder / "box.msh";
  run_or_fail("gmsh -3 -order 2 " + (folder / "box.geo").string() + " " + GetParam() + " -o " + mesh.string());
  const std::string message = message_of([&] { read_mesh(mesh); });
  EXPECT_NE(message.find("second-order tetrahedra"), std::string::npos) << message;
  EXPECT_NE(message.find("first order"), std::string::npos) << message;
}

TEST_P(FromGmsh, SurfaceMeshHasNoTets) {
  const TempFolder folder;
  write_bytes(folder / "box.geo", two_boxes);
  const auto mesh = folder / "box.msh";
  run_or_fail("gmsh -2 " + (folder / "box.geo").string() + " " + GetParam() + " -o " + mesh.string());
  EXPECT_NE(message_of([&] { read_mesh(mesh); }).find("no tetrahedra"), std::string::npos);
}

TEST(FromGmshVtk, AsciiAndBinary) {
  for (const char* flag : {"", "-bin "}) {
    const TempFolder folder;
    write_bytes(folder / "box.geo", two_boxes);
    const auto mesh = folder / "box.vtk";
    run_or_fail("gmsh -3 " + (folder / "box.geo").string() + " -format vtk " + flag + "-o " + mesh.string());
    const MeshFile file = read_mesh(mesh);
    EXPECT_NEAR(quality(file.mesh).volume, 3, 1e-12);
    EXPECT_EQ(regions_matching(file.mesh, "*", ""), std::vector<std::int32_t>{0});  // Gmsh writes no regions here
  }
}

TEST(FromGmshStl, AsciiAndBinary) {
  for (const char* flag : {"", "-bin "}) {
    const TempFolder folder;
    write_bytes(folder / "box.geo", "SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 1};\n");
    const auto path = folder / "box.stl";
    run_or_fail("gmsh -2 " + (folder / "box.geo").string() + " -format stl " + flag + "-o " + path.string());
    const Surface surface = read_surface(path);
    EXPECT_GT(surface.triangles.size(), 100u);
    EXPECT_TRUE(check_manifold(surface).closed_manifold());
  }
}

TEST(ToGmsh, ReadsWhatWeWrite) {
  const TetMesh mesh = biliary_mesh();
  for (const MeshFormat format :
       {MeshFormat::msh22, MeshFormat::msh22_binary, MeshFormat::msh41, MeshFormat::msh41_binary}) {
    const TempFolder folder;
    write_mesh(folder / "ours.msh", mesh, format, {{"u", 3, std::vector<double>(3 * mesh.vertex_count(), 0.5)}});
    run_or_fail("gmsh " + (folder / "ours.msh").string() + " -save -format msh22 -o " +
                (folder / "theirs.msh").string());
    const TetMesh back = read_mesh(folder / "theirs.msh").mesh;
    EXPECT_EQ(back.region_names, mesh.region_names);
    EXPECT_EQ(back.vertex_count(), mesh.vertex_count());
    for (const std::int32_t region : {2, 3, 4}) {
      EXPECT_EQ(quality(back, region).tets, quality(mesh, region).tets);
      EXPECT_NEAR(quality(back, region).volume, quality(mesh, region).volume, 1e-15);
    }
  }
}

// ---- meshio

const char* const write_all = R"(
import sys, numpy as np, meshio
folder = sys.argv[1]
points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.25, 0.25, 1], [0.25, 0.25, -1/3]])
tets = np.array([[0, 1, 2, 3], [0, 2, 1, 4]])
triangles = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]])
def mesh(name, dtype=float):
    return meshio.Mesh(points.astype(dtype), [("triangle", triangles), ("tetra", tets)],
        point_data={"u": np.arange(15.0).reshape(5, 3)},
        cell_data={name: [np.zeros(6, dtype=int), np.array([3, 8])], "noise": [np.ones(6), np.ones(2)]})
volume = mesh("region")
for name, options in {
        "ascii.vtu": dict(binary=False), "plain.vtu": dict(binary=True, compression=None),
        "zlib.vtu": dict(binary=True, compression="zlib")}.items():
    meshio.vtu.write(f"{folder}/{name}", volume, **options)
meshio.vtu.write(f"{folder}/float32.vtu", mesh("region", np.float32), binary=True, compression="zlib")
meshio.vtk.write(f"{folder}/ascii.vtk", volume, binary=False)
meshio.vtk.write(f"{folder}/binary.vtk", volume, binary=True)
from meshio.vtk import _vtk_42, _vtk_51
for module, name in (_vtk_42, "42"), (_vtk_51, "51"):
    for binary in (False, True):
        module.write(f"{folder}/v{name}{'b' if binary else 'a'}.vtk", volume, binary=binary)
for version in ("2.2", "4.1"):
    for binary in (False, True):
        tags = [np.zeros(6, dtype=int), np.array([3]), np.array([8])]  # version 4.1 keeps one tag a block
        tagged = meshio.Mesh(points, [("triangle", triangles), ("tetra", tets[:1]), ("tetra", tets[1:])],
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={"first": np.array([3, 3]), "second": np.array([8, 3])})
        if version == "4.1":
            tagged.point_data["gmsh:dim_tags"] = np.array([[3, 3]] * 4 + [[3, 8]])
        meshio.gmsh.write(f"{folder}/v{version}{'b' if binary else 'a'}.msh", tagged, version, binary=binary)
surface = meshio.Mesh(points, [("triangle", triangles)])
for binary in (False, True):
    meshio.stl.write(f"{folder}/{'b' if binary else 'a'}.stl", surface, binary=binary)
    meshio.ply.write(f"{folder}/{'b' if binary else 'a'}.ply", surface, binary=binary)
meshio.ply.write(f"{folder}/f.ply", meshio.Mesh(points.astype(np.float32), [("triangle", triangles)]))
meshio.obj.write(f"{folder}/a.obj", surface)
)";

/// What the script calls `volume`, give or take the precision it was written with.
void expect_meshio_volume(const std::filesystem::path& path, double tolerance) {
  SCOPED_TRACE(path.filename());
  MeshFile file;
  const std::string message = message_of([&] { file = read_mesh(path); });
  ASSERT_EQ(message, "");
  ASSERT_EQ(file.mesh.vertex_count(), 5u);
  EXPECT_NEAR((file.mesh.positions[4] - Vec3(0.25, 0.25, -1.0 / 3)).norm(), 0, tolerance);
  EXPECT_EQ(file.mesh.tets, two_tets().tets);
  EXPECT_EQ(file.mesh.regions, (std::vector<std::int32_t>{3, 8}));
  ASSERT_FALSE(file.notes.empty());
  EXPECT_EQ(file.notes[0], "6 triangles ignored");
}

TEST(FromMeshio, Everything) {
  const TempFolder folder;
  write_bytes(folder / "write.py", write_all);
  run_or_fail("/usr/bin/python3 " + (folder / "write.py").string() + " " + folder.path().string());
  for (const char* name :
       {"plain.vtu", "zlib.vtu", "ascii.vtk", "binary.vtk", "v42a.vtk", "v42b.vtk", "v51a.vtk", "v51b.vtk"})
    expect_meshio_volume(folder / name, 0);
  expect_meshio_volume(folder / "ascii.vtu", 1e-11);  // eleven digits is what it writes
  expect_meshio_volume(folder / "float32.vtu", 1e-7);
  for (const char* name : {"v2.2a.msh", "v2.2b.msh", "v4.1a.msh", "v4.1b.msh"}) {
    expect_meshio_volume(folder / name, 1e-15);
    EXPECT_EQ(read_mesh(folder / name).mesh.region_names,
              (std::map<std::int32_t, std::string>{{3, "first"}, {8, "second"}}));
  }
  for (const char* name : {"a.stl", "b.stl", "a.ply", "b.ply", "f.ply", "a.obj"}) {
    SCOPED_TRACE(name);
    const Surface surface = read_surface(folder / name);
    EXPECT_EQ(surface.positions.size(), 5u);
    EXPECT_EQ(surface.triangles.size(), 6u);
    EXPECT_TRUE(check_manifold(surface).closed_manifold());
  }
}

const char* const read_all = R"(
import sys, glob, numpy as np, meshio
folder = sys.argv[1]
def load(path):
    if path.endswith("msh"): return meshio.gmsh.read(path)
    return meshio.vtu.read(path) if path.endswith("vtu") else meshio.vtk.read(path)
points = np.loadtxt(f"{folder}/points.txt")
tets = np.loadtxt(f"{folder}/tets.txt", dtype=int)
names = ("gallbladder", "cystic duct", "common bile duct")
for path in sorted(glob.glob(f"{folder}/mesh_*")):
    mesh = load(path)
    assert np.array_equal(mesh.points, points), path
    assert np.array_equal(np.vstack([c.data for c in mesh.cells]), tets[:, :4]), path
    assert np.array_equal(mesh.point_data["u"], 2 * points), path
    if path.endswith("msh"):
        for id, name in zip((2, 3, 4), names): assert list(mesh.field_data[name]) == [id, 3], path
    else:
        assert np.array_equal(np.concatenate(mesh.cell_data["region"]).ravel(), tets[:, 4]), path
    if path.endswith("vtu"):
        assert list(mesh.field_data["region_ids"]) == [2, 3, 4], path
        text = bytes(mesh.field_data["region_names"]).decode()
        assert text == "".join(n + "\0" for n in names), path
    print("read", path)
for path in sorted(glob.glob(f"{folder}/surface_*")):
    mesh = meshio.read(path)
    assert len(mesh.cells_dict["triangle"]) == len(np.loadtxt(f"{folder}/triangles.txt")), path
    print("read", path)
)";

TEST(ToMeshio, ReadsWhatWeWrite) {
  const TempFolder folder;
  const TetMesh mesh = biliary_mesh();
  std::string points, tets, triangles;
  VertexArray twice{"u", 3, {}};
  for (const Vec3& p : mesh.positions) {
    std::array<char, 100> line;
    std::snprintf(line.data(), line.size(), "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    points += line.data();
    for (const double x : p) twice.values.push_back(2 * x);
  }
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    for (const VertexId v : mesh.tets[t]) tets += std::to_string(v.value) + " ";
    tets += std::to_string(mesh.regions[t]) + "\n";
  }
  Surface surface = boundary_surface(mesh);
  surface.regions.clear();  // meshio can't read face properties beside the list of corners
  for (const Triangle& t : surface.triangles)
    triangles += std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  write_bytes(folder / "points.txt", points);
  write_bytes(folder / "tets.txt", tets);
  write_bytes(folder / "triangles.txt", triangles);
  write_bytes(folder / "read.py", read_all);
  const std::vector<std::pair<std::string, MeshFormat>> files{
      {"mesh_22a.msh", MeshFormat::msh22},      {"mesh_22b.msh", MeshFormat::msh22_binary},
      {"mesh_41a.msh", MeshFormat::msh41},      {"mesh_41b.msh", MeshFormat::msh41_binary},
      {"mesh_a.vtu", MeshFormat::vtu_ascii},    {"mesh_b.vtu", MeshFormat::vtu_base64},
      {"mesh_r.vtu", MeshFormat::vtu_appended}, {"mesh_z.vtu", MeshFormat::vtu_zlib},
      {"mesh_a.vtk", MeshFormat::vtk_ascii},    {"mesh_b.vtk", MeshFormat::vtk_binary}};
  for (const auto& [name, format] : files) write_mesh(folder / name, mesh, format, {twice});
  const std::vector<std::pair<std::string, SurfaceFormat>> surfaces{{"surface_a.stl", SurfaceFormat::stl_ascii},
                                                                    {"surface_b.stl", SurfaceFormat::stl_binary},
                                                                    {"surface_a.ply", SurfaceFormat::ply_ascii},
                                                                    {"surface_b.ply", SurfaceFormat::ply_binary},
                                                                    {"surface_a.obj", SurfaceFormat::obj}};
  for (const auto& [name, format] : surfaces) write_surface(folder / name, surface, format);
  run_or_fail("/usr/bin/python3 " + (folder / "read.py").string() + " " + folder.path().string());
}

}  // namespace
