// From a scene to a model: shapes with the volume they should have, regions with their figures, patients with theirs.
#include "calot/scene/tissue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "calot/scene/scene_file.h"
#include "calot/scene/shape_mesh.h"
#include "fuzz/tiny_patient.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace calot::test {
namespace {

double volume_of(const TetMesh& mesh) {
  double volume = 0;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) volume += signed_volume(mesh, TetId(t));
  return volume;
}

Scene read_text(const std::string& text) {
  const TempFolder folder;
  write_bytes(folder / "s.toml", text);
  return read_scene(folder / "s.toml");
}

TEST(ShapeMesh, ABlockIsWhole) {
  BlockShape block;
  block.region = "liver";
  block.centre = Vec3(0.1, 0, 0);
  block.size = Vec3(0.06, 0.02, 0.03);
  block.element_size = 0.005;
  block.fixed = {true, false, false, false, false, true};
  const ShapeMesh made = mesh_of_shapes({block}, {});
  EXPECT_EQ(validate(made.mesh).describe(), "");
  EXPECT_TRUE(check_manifold(boundary_surface(made.mesh)).closed_manifold());
  EXPECT_EQ(made.mesh.tet_count(), 6u * 12 * 4 * 6);
  EXPECT_NEAR(volume_of(made.mesh), 0.06 * 0.02 * 0.03, 1e-18);
  EXPECT_EQ(made.mesh.region_names.at(label_of(Structure::liver)), "liver");
  std::size_t held = 0;
  for (std::size_t v = 0; v < made.mesh.vertex_count(); ++v) {
    const Vec3& p = made.mesh.positions[v];
    EXPECT_EQ(made.fixed[v] != 0, p.x() < 0.07 + 1e-9 || p.z() > 0.015 - 1e-9);
    held += made.fixed[v];
  }
  EXPECT_EQ(held, 5u * 7 + 13u * 5 - 5);
}

TEST(ShapeMesh, ATubeHasItsVolumeAndItsRegions) {
  TubeShape tube;
  tube.points = {{0, 0, 0}, {0.03, 0, 0}, {0.03, 0.03, 0.01}};
  tube.radii = {0.002, 0.002, 0.004};
  tube.regions = {"cystic duct", "something else"};
  tube.fixed_first = true;
  double before = 1;
  for (const int rings : {1, 2, 4, 8}) {
    tube.rings = rings;
    const ShapeMesh made = mesh_of_shapes({}, {tube});
    EXPECT_EQ(validate(made.mesh).describe(), "") << rings;
    EXPECT_TRUE(check_manifold(boundary_surface(made.mesh)).closed_manifold()) << rings;
    // A cylinder and a cone's stump.
    const double second = (tube.points[2] - tube.points[1]).norm();
    const double exact = M_PI * (4e-6 * 0.03 + second * (4e-6 + 8e-6 + 16e-6) / 3);
    const double error = std::abs(volume_of(made.mesh) / exact - 1);
    EXPECT_LT(error, 0.75 * before) << rings;
    before = error;
    const std::set<std::int32_t> regions(made.mesh.regions.begin(), made.mesh.regions.end());
    EXPECT_EQ(regions, (std::set<std::int32_t>{label_of(Structure::cystic_duct), 100}));
    for (std::size_t v = 0; v < made.mesh.vertex_count(); ++v)
      EXPECT_EQ(made.fixed[v] != 0, made.mesh.positions[v].x() < 1e-9 && made.mesh.positions[v].y() < 3e-3);
  }
  EXPECT_LT(before, 0.02);
}

TEST(ShapeMesh, ATubesTetsAreWellShaped) {
  TubeShape tube;
  tube.points = {{0, 0, 0}, {0.04, 0, 0}};
  tube.radii = {0.002, 0.002};
  tube.regions = {"cystic duct"};
  tube.rings = 3;
  const TetMesh mesh = mesh_of_shapes({}, {tube}).mesh;
  const Quality found = quality(mesh);
  EXPECT_GT(found.min_dihedral, 15);
  EXPECT_LT(found.max_dihedral, 150);
}

TEST(ShapeMesh, RefusesFoldsAndTooMany) {
  TubeShape tube;
  tube.where = "s.toml:3";
  tube.points = {{0, 0, 0}, {0.01, 0, 0}, {0.0, 0.001, 0}};
  tube.radii = {0.004, 0.004, 0.004};
  tube.regions = {"a", "a"};
  EXPECT_NE(message_of([&] { mesh_of_shapes({}, {tube}); }).find("s.toml:3: the shape folds"), std::string::npos);
  BlockShape block;
  block.where = "s.toml:9";
  block.size = Vec3::Constant(1);
  block.element_size = 0.001;
  EXPECT_NE(message_of([&] { mesh_of_shapes({block}, {}); }).find("s.toml:9: the shapes would have more"),
            std::string::npos);
}

const std::string two =
    "length_unit = \"mm\"\ntime_step = 0.01\nrayleigh_mass = 3\n"
    "[[block]]\nregion = \"liver\"\nsize = [20, 10, 10]\nelement_size = 5\nfixed = [\"x-\"]\n"
    "[[block]]\nregion = \"phantom gel\"\ncentre = [100, 0, 0]\nsize = [20, 10, 10]\nelement_size = 5\n";

TEST(LoadTissue, RegionsGetTheirFiguresAndLaterOnesWin) {
  const SceneTissue tissue = load_tissue(
      read_text(two + "[[region]]\nregion = \"*\"\nyoung = 5000\nfriction = 0.3\n"
                      "[[region]]\nregion = \"phantom gel\"\nyoung = 9000\ndensity = 1200\nultimate_stretch = 2\n"));
  const TetMesh& mesh = tissue.model.mesh();
  const auto region = [&](const std::string& name) { return regions_matching(mesh, name, "")[0]; };
  EXPECT_EQ(tissue.model.materials().at(region("liver")).young, 5000);
  EXPECT_EQ(tissue.model.materials().at(region("liver")).density, material_of(Structure::liver).density);
  EXPECT_EQ(tissue.model.materials().at(region("phantom gel")).young, 9000);
  EXPECT_EQ(tissue.properties.at(region("phantom gel")).density, 1200);
  EXPECT_EQ(tissue.properties.at(region("phantom gel")).ultimate_stretch, 2);
  EXPECT_EQ(tissue.properties.at(region("liver")).ultimate_stretch, tissue_properties("liver").ultimate_stretch);
  EXPECT_EQ(tissue.properties.at(region("liver")).friction, 0.3);
  EXPECT_EQ(tissue.bodies.at(region("liver")), BodyKind::deformable);
  EXPECT_EQ(tissue.model.dynamics().time_step, 0.01);
  EXPECT_EQ(tissue.model.dynamics().rayleigh_mass, 3);
  EXPECT_FALSE(tissue.patient);
  EXPECT_EQ(face_connected_parts(mesh).count(), 2u);
}

TEST(LoadTissue, AStaticRegionIsHeldWholly) {
  const SceneTissue tissue = load_tissue(read_text(two + "[[region]]\nregion = \"phantom gel\"\nbody = \"static\"\n"));
  for (std::size_t v = 0; v < tissue.model.mesh().vertex_count(); ++v) {
    const double x = tissue.model.mesh().positions[v].x();
    EXPECT_EQ(tissue.model.fixed()[v] != 0, x > 0.05 || x < -0.01 + 1e-9);
  }
}

TEST(LoadTissue, NamesTheLineOfARegionThatIsNotThere) {
  const std::string found =
      message_of([] { load_tissue(read_text(two + "[[region]]\nregion = \"spleen\"\nyoung = 1e4\n")); });
  EXPECT_NE(found.find("s.toml:14"), std::string::npos) << found;
  EXPECT_NE(found.find("spleen"), std::string::npos) << found;
}

TEST(LoadTissue, AModelFileKeepsWhatItSays) {
  const TempFolder folder;
  const Model model = biliary_model(0.02);
  write_mesh(folder / "m.msh", model.mesh());
  save_model(folder / "model.toml", model, "m.msh");
  write_bytes(folder / "s.toml", "model = \"model.toml\"\n[[region]]\nregion = \"cystic duct\"\nyoung = 7e5\n");
  const SceneTissue tissue = load_tissue(read_scene(folder / "s.toml"));
  EXPECT_EQ(tissue.model.mesh().positions, model.mesh().positions);
  EXPECT_EQ(tissue.model.fixed(), model.fixed());
  EXPECT_EQ(tissue.model.materials().at(3).young, 7e5);
  EXPECT_EQ(tissue.model.materials().at(2), model.materials().at(2));
  EXPECT_EQ(tissue.model.dynamics().time_step, 1.0 / 60);
}

TEST(LoadTissue, APatientBringsAttachmentsPortsAndMaterials) {
  const TempFolder folder;
  fuzz::write_tiny_files(folder.path());
  write_bytes(folder / "patient.toml", fuzz::tiny_patient_toml());
  write_bytes(folder / "s.toml",
              "patient = \".\"\n[[instrument]]\nname = \"a\"\nkind = \"hook\"\nport = \"epigastric\"\n"
              "keyframes = [{ time = 0, tip = [0.01, 0, 0] }]\n[[instrument]]\nname = \"b\"\nkind = \"hook\"\n"
              "port = \"epigastrik\"\nkeyframes = [{ time = 0, tip = [0.01, 0, 0] }]\n");
  const Scene scene = read_scene(folder / "s.toml");
  const SceneTissue tissue = load_tissue(scene);
  ASSERT_TRUE(tissue.patient);
  EXPECT_EQ(tissue.model.materials().at(label_of(Structure::liver)).young, material_of(Structure::liver).young);
  for (std::size_t v = 0; v < tissue.model.mesh().vertex_count(); ++v)
    EXPECT_EQ(tissue.model.fixed()[v] != 0, v == 4 || v == 9 || v == 14) << v;  // not the peritoneum's 1 and 6
  EXPECT_EQ(tissue.carried.size(), tissue.bodies.size());                       // it lies in balance as it was imaged
  EXPECT_LT((*port_of(scene.instruments[0], tissue) - Vec3(0.05, 0.15, 0)).norm(), 1e-9);
  const std::string found = message_of([&] { port_of(scene.instruments[1], tissue); });
  EXPECT_NE(found.find("s.toml:7"), std::string::npos) << found;
  EXPECT_NE(found.find("did you mean epigastric?"), std::string::npos) << found;
}

TEST(LoadTissue, ARegionIsCarriedWhereTheSceneSaysSo) {
  EXPECT_TRUE(load_tissue(read_text(two)).carried.empty());
  const SceneTissue one = load_tissue(
      read_text(two + "[[region]]\nregion = \"*\"\ncarried = true\n[[region]]\nregion = \"liver\"\ncarried = false\n"));
  EXPECT_EQ(one.carried, (std::set{regions_matching(one.model.mesh(), "phantom gel", "")[0]}));
  const TempFolder folder;
  fuzz::write_tiny_files(folder.path());
  write_bytes(folder / "patient.toml", fuzz::tiny_patient_toml());
  write_bytes(folder / "s.toml", "patient = \".\"\n[[region]]\nregion = \"*\"\ncarried = false\n");
  EXPECT_TRUE(load_tissue(read_scene(folder / "s.toml")).carried.empty());
}

TEST(LoadTissue, AFloorFacesItsNormal) {
  const Scene scene = read_text(two + "[[floor]]\npoint = [0, 0, -30]\nnormal = [0, 3, 4]\nsize = 200\n");
  const Surface floor = load_surface(scene.surfaces[0]);
  double area = 0;
  for (const Triangle& t : floor.triangles) {
    const Vec3 n =
        0.5 * (floor.positions[t[1]] - floor.positions[t[0]]).cross(floor.positions[t[2]] - floor.positions[t[0]]);
    area += n.norm();
    EXPECT_LT((n.normalized() - Vec3(0, 0.6, 0.8)).norm(), 1e-12);
  }
  EXPECT_NEAR(area, 0.04, 1e-15);
}

}  // namespace
}  // namespace calot::test
