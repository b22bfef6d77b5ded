// What `calot cut` does at its edges.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "tests/app/program.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

nlohmann::json summary_in(const ModelFolder& folder, const std::string& output) {
  return nlohmann::json::parse(read_bytes(folder.name(output + "/summary.json")));
}

TEST(CutCommand, RemovingNothingIsAWarningAndTheFilesAreWritten) {
  const ModelFolder folder;
  folder.precompute();
  const Outcome run =
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", "9m,0,0,1,0,0", "-o", folder.name("cut")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err, "calot: warning: the cut removes nothing\n");
  EXPECT_EQ(names_in(folder.name("cut")).size(), 5u);
  EXPECT_EQ(load_model(folder.name("cut/model.toml")).fingerprint(), load_model(folder.model()).fingerprint());
  EXPECT_EQ(summary_in(folder, "cut").at("tets_removed"), 0);
}

TEST(CutCommand, AStaticPartWithoutSupportIsNamedAndNothingIsWritten) {
  const ModelFolder folder(0.0);
  folder.precompute();
  const auto before = names_in(folder.path());
  for (const std::string method : {"exact", "paper", "recompute"})
    expect_refused(calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "--method", method,
                              "-o", folder.name("cut")}),
                   1, {"part", "tets", "without support"});
  expect_refused(
      calot_run({"compare", folder.model(), "--plane", duct_plane, "--force", "3,1,0,0", "-o", folder.name("cut")}), 1,
      {"without support"});
  EXPECT_EQ(names_in(folder.path()), before);
}

TEST(CutCommand, RemovingEverythingIsRefused) {
  const ModelFolder folder;
  folder.precompute();
  TempFolder other;
  write_mesh(other / "one.msh", regular_tet(0.01));
  write_bytes(other / "model.toml",
              "mesh = \"one.msh\"\ntime_step = 0.01\n[[material]]\nregion = \"*\"\nyoung = 1e5\npoisson = 0.4\n");
  ASSERT_EQ(calot_run({"precompute", (other / "model.toml").string(), "-o", (other / "C.h5").string()}).code, 0);
  expect_refused(calot_run({"cut", (other / "model.toml").string(), (other / "C.h5").string(), "--plane", "0,0,0,0,0,1",
                            "-o", (other / "cut").string()}),
                 1, {"every tetrahedron"});
  EXPECT_FALSE(std::filesystem::exists(other / "cut"));
}

TEST(CutCommand, RegionBladeAndClean) {
  const ModelFolder folder;
  folder.precompute();
  const std::vector<std::string> base{"cut", folder.model(), folder.compliance()};
  const auto cut = [&](std::vector<std::string> more, const std::string& output) {
    std::vector<std::string> arguments = base;
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {"-o", folder.name(output)});
    const Outcome run = calot_run(arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    return summary_in(folder, output);
  };
  const auto all = cut({"--plane", "20mm,15mm,30mm,0.2,0.1,1"}, "all");
  const auto region = cut({"--plane", "20mm,15mm,30mm,0.2,0.1,1", "--region", "cystic duct"}, "region");
  EXPECT_LT(region.at("tets_removed"), all.at("tets_removed"));
  const auto blade = cut({"--blade", "20mm,15mm,30mm,0.2,0.1,1,1,0,0,8mm,8mm"}, "blade");
  EXPECT_GT(blade.at("tets_removed"), 0);
  EXPECT_LT(blade.at("tets_removed"), all.at("tets_removed"));
  const auto clean = cut({"--plane", "20mm,15mm,30mm,0.2,0.1,1", "--clean"}, "clean");
  EXPECT_EQ(clean.at("hanging"), 0);
  EXPECT_EQ(clean.at("tets_removed"), all.at("tets_removed").get<int>() + all.at("hanging").get<int>());
}

TEST(CutCommand, APlaneInFacesSaysThatTheLowerTetsWent) {
  TempFolder folder;
  write_mesh(folder / "box.msh", box_mesh(4, 3, 3, {0.04, 0.03, 0.03}));
  write_bytes(folder / "model.toml",
              "mesh = \"box.msh\"\ntime_step = 0.01\n[[material]]\nregion = \"*\"\nyoung = 1e5\npoisson = "
              "0.4\n[[fixed]]\nbox = { min = [0, 0, 0], max = [0, 1, 1] }\n");
  const std::string model = (folder / "model.toml").string(), compliance = (folder / "C.h5").string();
  ASSERT_EQ(calot_run({"precompute", model, "-o", compliance}).code, 0);
  const Outcome run =
      calot_run({"cut", model, compliance, "--plane", "0.02,0,0,1,0,0", "-o", (folder / "cut").string()});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto summary = nlohmann::json::parse(read_bytes(folder / "cut/summary.json"));
  EXPECT_EQ(summary.at("tets_removed"), 18);
  EXPECT_NE(summary.at("notes").dump().find("below it went too"), std::string::npos) << summary;
}

TEST(CutCommand, UniformMassKeepsEachShare) {
  const ModelFolder folder;
  folder.edit_model("mass_lumping = \"element\"", "mass_lumping = \"uniform\"\ntotal_mass = 0.0137");
  folder.precompute();
  // Close planes, so that vertices go.
  ASSERT_EQ(calot_run({"cut", folder.model(), folder.compliance(), "--plane", "40mm,0,0,1,0,0", "--plane",
                       "43mm,0,0,1,0,0", "--plane", "47mm,0,0,1,0,0", "-o", folder.name("cut")})
                .code,
            0);
  const Model before = load_model(folder.model()), after = load_model(folder.name("cut/model.toml"));
  EXPECT_LT(after.mesh().vertex_count(), before.mesh().vertex_count());
  EXPECT_NEAR(after.uniform_share(), before.uniform_share(), 4e-16 * before.uniform_share());
  EXPECT_EQ(calot_run({"solve", folder.name("cut/model.toml"), folder.name("cut/C.h5"), "--force", "3,0,0,1", "-o",
                       folder.name("u.csv")})
                .code,
            0);
}

TEST(CutCommand, WritesIntoAnExistingFolderAndMakesMissingOnes) {
  const ModelFolder folder;
  folder.precompute();
  std::filesystem::create_directory(folder.name("there"));
  write_bytes(folder.name("there/notes.txt"), "mine");
  write_bytes(folder.name("there/cut.msh"), "old");
  const auto cut = [&](const std::string& output) {
    return calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.name(output)})
        .code;
  };
  EXPECT_EQ(cut("there"), 0);
  EXPECT_EQ(read_bytes(folder.name("there/notes.txt")), "mine");
  EXPECT_EQ(names_in(folder.name("there")).size(), 6u);
  EXPECT_NO_THROW(load_model(folder.name("there/model.toml")));
  EXPECT_EQ(cut("a/b/c/"), 0);
  EXPECT_EQ(names_in(folder.name("a/b/c")).size(), 5u);
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"C.h5", "a", "model.toml", "organ.msh", "there"}));
}

TEST(CutCommand, NeverOverwritesItsInput) {
  const ModelFolder folder;
  folder.precompute();
  const std::string before = read_bytes(folder.model());
  expect_refused(
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.path().string()}), 2,
      {"overwritten"});
  EXPECT_EQ(read_bytes(folder.model()), before);
}

TEST(CutCommand, VerticesWithoutTetsAreLeftOut) {
  ModelFolder folder;
  // A stray point in the mesh file, as Gmsh leaves them: number 390 in the file, 389 here.
  std::string text = read_bytes(folder.mesh());
  const std::size_t end = text.find("$EndNodes");
  ASSERT_NE(end, std::string::npos);
  text.insert(end, "390 1 2 3\n");
  const std::size_t count = text.find("\n389\n");
  ASSERT_NE(count, std::string::npos);
  text.replace(count, 5, "\n390\n");
  write_bytes(folder.mesh(), text);
  folder.precompute();
  EXPECT_EQ(python("import h5py, sys\nf = h5py.File(sys.argv[1])\nprint(f['compliance'].shape, f['node_ids'][:].max())",
                   {folder.compliance()}),
            "(1167, 1167) 388\n");
  ASSERT_EQ(
      calot_run({"solve", folder.model(), folder.compliance(), "--force", "300,0,1,0", "-o", folder.name("u.csv")})
          .code,
      0);
  const std::string csv = read_bytes(folder.name("u.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 391);
  EXPECT_TRUE(csv.ends_with("\n0,0,0\n"));
  ASSERT_EQ(
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.name("cut")}).code, 0);
  EXPECT_TRUE(read_bytes(folder.name("cut/vertex_map.csv")).ends_with("\n389,-1\n"));
}

}  // namespace
}  // namespace calot::test
