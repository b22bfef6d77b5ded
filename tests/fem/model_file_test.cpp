// model.toml: what it says is what the model is, and what is written reads back to the last bit.
#include "calot/fem/model_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calot/base/error.h"
#include "calot/mesh/mesh_file.h"
#include "tests/support/edits.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace calot::test {
namespace {

/// Writes mesh and model beside each other and reads them back.
Model written_and_read(const Model& model) {
  const TempFolder folder;
  write_mesh(folder / "m.msh", model.mesh());
  save_model(folder / "model.toml", model, "m.msh");
  return load_model(folder / "model.toml");
}

TEST(ModelFile, ReadsBackBitForBit) {
  for (const double time_step : {0.0, 0.02, 1.0 / 3, 1e-9}) {
    const Model model = biliary_model(time_step), read = written_and_read(model);
    EXPECT_EQ(read.fingerprint(), model.fingerprint());
    EXPECT_EQ(read.materials(), model.materials());
    EXPECT_EQ(read.fixed(), model.fixed());
    EXPECT_EQ(read.mesh().region_names, model.mesh().region_names);
    EXPECT_EQ(read.dynamics().rayleigh_mass, model.dynamics().rayleigh_mass);
  }
}

TEST(ModelFile, KeepsAwkwardNumbersAndNames) {
  TetMesh mesh = box_mesh(2, 1, 1, {1.0 / 3, 0.1, 1e-3});
  mesh.region_names[1] = "a \"wall\" \\ of\tducts, n\xc2\xba 1";
  const Model model(mesh, {{1, {std::nextafter(1e6, 2e6), 0.1 + 0.2, 5e-300}}},
                    std::vector<std::uint8_t>(mesh.vertex_count(), 0),
                    {.time_step = 1e-7, .rayleigh_mass = 1e22, .rayleigh_stiffness = 123456789012345678.0});
  const TempFolder folder;
  mesh.region_names.clear();  // mesh files take plain names only; model.toml takes any
  write_mesh(folder / "m.msh", mesh);
  save_model(folder / "model.toml", model, "m.msh");
  const Model read = load_model(folder / "model.toml");
  EXPECT_EQ(read.fingerprint(), model.fingerprint());
  EXPECT_EQ(read.mesh().region_names, model.mesh().region_names);
}

TEST(ModelFile, KeepsTheShareOfUniformMass) {
  Random random(5);
  for (int i = 0; i < 30; ++i) {
    const TetMesh mesh = box_mesh(1 + static_cast<int>(random.below(4)), 2, 2, {1, 1, 1});
    Model model(mesh, {{1, {}}}, std::vector<std::uint8_t>(mesh.vertex_count(), 0),
                {.mass_lumping = MassLumping::uniform}, random.between(0.001, 10));
    model.apply({.removed = random_tets(mesh, mesh.tet_count() / 3, random.next()), .vertices = {}, .tets = {}});
    EXPECT_NEAR(written_and_read(model).uniform_share(), model.uniform_share(), 2.3e-16 * model.uniform_share());
  }
}

// What splits and heat leave behind: uneven shares and factors on the stiffness, to the last bit.
TEST(ModelFile, KeepsUnevenMassesAndScaledStiffness) {
  const TetMesh mesh = box_mesh(2, 2, 2, {1, 1, 1});
  Model model(mesh, {{1, {}}}, std::vector<std::uint8_t>(mesh.vertex_count(), 0),
              {.mass_lumping = MassLumping::uniform}, 0.7);
  model.apply(random_bisections(mesh, 4, 3));
  (void)model.scale_stiffness(std::vector{TetId(1), TetId(5)}, std::vector{1.0 / 3, 7.5});
  ASSERT_FALSE(model.has_even_masses());
  const Model read = written_and_read(model);
  EXPECT_EQ(read.vertex_masses(), model.vertex_masses());
  EXPECT_EQ(read.stiffness_scale(), model.stiffness_scale());
  EXPECT_EQ(read.fingerprint(), model.fingerprint());
}

/// A model.toml over the box of 2 × 1 × 1 cubes, 20 × 10 × 10 mm, written in millimetres.
class ModelText : public testing::Test {
 protected:
  void SetUp() override {
    TetMesh mesh = bar_mesh(2, 20, 10);
    write_mesh(folder / "bar.msh", mesh);
  }
  Model load(const std::string& text) {
    write_bytes(folder / "model.toml", "mesh = \"bar.msh\"\nlength_unit = \"mm\"\n" + text);
    return load_model(folder / "model.toml");
  }
  std::size_t fixed_count(const std::string& text) {
    const Model model = load(text + "[[material]]\nregion = \"*\"\nyoung = 1\npoisson = 0\n");
    return static_cast<std::size_t>(std::count(model.fixed().begin(), model.fixed().end(), 1));
  }
  TempFolder folder;
};

TEST_F(ModelText, UnitsAndDefaults) {
  const Model model = load("[[material]]\nregion = \"*\"\nyoung = 1000000\npoisson = 0\n");
  EXPECT_EQ(model.mesh().positions.back(), Vec3(20 * 1e-3, 10 * 1e-3, 10 * 1e-3));
  EXPECT_EQ(model.dynamics().time_step, 0.02);
  EXPECT_EQ(model.dynamics().rayleigh_mass, 0);
  EXPECT_EQ(model.dynamics().mass_lumping, MassLumping::element);
  EXPECT_EQ(model.materials().at(1), (Material{1e6, 0, 1000}));
  EXPECT_EQ(model.origin().mesh_sha256.size(), 64u);
  EXPECT_EQ(model.origin().mesh_file, folder / "bar.msh");
}

TEST_F(ModelText, LaterMaterialsWinAndRegionsGoByNameOrNumber) {
  const auto material = [](const std::string& region, int young) {
    return "[[material]]\nregion = " + region + "\nyoung = " + std::to_string(young) + "\npoisson = 0.3\n";
  };
  Model model = load(material("\"*\"", 10) + material("\"far\"", 20));
  EXPECT_EQ(model.materials().at(1).young, 10);
  EXPECT_EQ(model.materials().at(2).young, 20);
  model = load(material("2", 20) + material("\"1\"", 30) + material("\"*\"", 10));
  EXPECT_EQ(model.materials().at(1).young, 10);
  EXPECT_EQ(model.materials().at(2).young, 10);
  model = load("region_names = { 1 = \"stump\", 2 = \"tip\" }\n" + material("\"stump\"", 1) + material("\"tip\"", 2));
  EXPECT_EQ(model.materials().at(2).young, 2);
  EXPECT_EQ(model.mesh().region_names.at(1), "stump");
}

TEST_F(ModelText, SupportsAddUp) {
  EXPECT_EQ(fixed_count(""), 0u);
  EXPECT_EQ(fixed_count("[[fixed]]\nvertices = [0, 3, 3]\n"), 2u);
  EXPECT_EQ(fixed_count("[[fixed]]\nbox = { min = [0, 0, 0], max = [0, 10, 10] }\n"),
            9u);  // faces of a box belong to it
  EXPECT_EQ(fixed_count("[[fixed]]\nbox = { min = [20.0, 10.0, 10.0], max = [20.0, 10.0, 10.0] }\n"), 1u);
  EXPECT_EQ(fixed_count("[[fixed]]\nregion = \"far\"\n"), 18u);
  EXPECT_EQ(fixed_count("[[fixed]]\nregion = \"far\"\n[[fixed]]\nvertices = [0]\n"), 19u);
}

TEST_F(ModelText, UniformMassIsDensityTimesVolumeUnlessGiven) {
  const std::string material = "[[material]]\nregion = \"*\"\nyoung = 1\npoisson = 0\ndensity = 500\n";
  EXPECT_NEAR(load("mass_lumping = \"uniform\"\n" + material).uniform_share(), 500 * 2e-6 / 27, 1e-18);
  EXPECT_EQ(load("mass_lumping = \"uniform\"\ntotal_mass = 27\n" + material).uniform_share(), 1);
}

TEST_F(ModelText, AMeshElsewhereIsFoundFromTheModelsFolder) {
  std::filesystem::create_directory(folder / "deep");
  write_bytes(folder / "deep/model.toml",
              "mesh = \"../bar.msh\"\n[[material]]\nregion = \"*\"\nyoung = 1\npoisson = 0\n");
  EXPECT_EQ(load_model(folder / "deep/model.toml").mesh().vertex_count(), 27u);
}

}  // namespace
TEST_F(ModelText, RefusesListsThatDoNotFit) {
  const std::string material = "[[material]]\nregion = \"*\"\nyoung = 1\npoisson = 0\n";
  const auto refused = [&](const std::string& lines, const std::string& why) {
    try {
      load(lines + material);
      ADD_FAILURE() << "accepted: " << lines;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused("stiffness_scale = [1.0, 2.0]\n", "has 2 values");
  refused("stiffness_scale = [1.0, 0.0]\n", "numbers > 0");
  refused("stiffness_scale = 3\n", "stiffness_scale");
  refused("mass_lumping = \"uniform\"\nvertex_masses = [1.0]\n", "has 1 values");
  std::string masses = "vertex_masses = [";
  for (int v = 0; v < 27; ++v) masses += "1.0, ";
  refused(masses + "]\n", "uniform");
  EXPECT_EQ(load("mass_lumping = \"uniform\"\n" + masses + "]\n" + material).vertex_masses()[3], 1);
}

}  // namespace calot::test
