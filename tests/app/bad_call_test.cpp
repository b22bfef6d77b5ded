// Wrong calls: exit code 2, one line, and help that helps.
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace calot::test {
namespace {

const std::vector<std::string> commands{"phantom", "mesh", "precompute", "cut", "solve", "compare", "convert", "bench"};

TEST(Call, EveryCommandHasHelpWithAnExample) {
  const Outcome all = calot_run({"--help"});
  EXPECT_EQ(all.code, 0);
  for (const std::string& command : commands) {
    EXPECT_NE(all.out.find("  " + command + " "), std::string::npos) << command;
    const Outcome run = calot_run({command, "--help"});
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.err, "");
    EXPECT_NE(run.out.find("Example"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("calot " + command + " "), std::string::npos) << run.out;
  }
}

TEST(Call, SaysItsVersion) {
  const Outcome run = calot_run({"--version"});
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.out, "calot 0.1.0\n");
}

TEST(Call, WrongOptionsAndCommands) {
  expect_refused(calot_run({}), 2, {"calot --help"});
  expect_refused(calot_run({"slice"}), 2, {"slice", "calot --help"});
  expect_refused(calot_run({"cut"}), 2, {"MODEL", "calot cut --help"});
  expect_refused(calot_run({"precompute", "m.toml"}), 2, {"--output", "calot precompute --help"});
  expect_refused(calot_run({"precompute", "m.toml", "-o", "C.h5", "--backend", "cloud"}), 2, {"--backend", "cloud"});
  expect_refused(calot_run({"precompute", "m.toml", "-o", "C.h5", "--fast"}), 2, {"--fast"});
  expect_refused(calot_run({"cut", "m.toml", "C.h5", "--method", "magic", "-o", "x", "--plane", "0,0,0,1,0,0"}), 2,
                 {"--method"});
  expect_refused(calot_run({"solve", "m.toml", "C.h5", "-o", "u.csv"}), 2, {"--force"});
  expect_refused(calot_run({"bench", "no-such-bench"}), 2, {"no-such-bench"});
}

class CutCall : public testing::Test {
 protected:
  void refused(const std::vector<std::string>& more, const std::vector<std::string>& parts) {
    std::vector<std::string> arguments{"cut", folder.model(), folder.compliance(), "-o", folder.name("cut")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(calot_run(arguments), 2, parts);
    EXPECT_FALSE(std::filesystem::exists(folder.name("cut")));
  }
  ModelFolder folder;
};

TEST_F(CutCall, WrongBlades) {
  refused({}, {"--plane"});
  refused({"--plane", "0,0,0,1,0"}, {"--plane 0,0,0,1,0", "5 values, not 6"});
  refused({"--plane", "0,0,0,1,0,0,0"}, {"7 values"});
  refused({"--plane", "0,0,zero,1,0,0"}, {"zero"});
  refused({"--plane", ""}, {"--plane"});
  refused({"--plane", "0,0,nan,1,0,0"}, {"nan"});
  refused({"--plane", "10mm,5,0,1,0,0"}, {"unit"});
  refused({"--plane", "10inch,0,0,1,0,0"}, {"inch"});
  refused({"--plane", "0,0,0,1mm,0,0"}, {"direction"});
  refused({"--plane", "0,0,0,0,0,0"}, {"blade 1", "length 0"});
  refused({"--blade", "0,0,0,1,0,0,1,0,0,1,1"}, {"parallel"});
  refused({"--blade", "0,0,0,1,0,0,0,1,0,0,1"}, {"length"});
  refused({"--plane", duct_plane, "--region", "spleen"}, {"spleen", "gallbladder"});
}

TEST_F(CutCall, NegativeFirstValuesAreNotOptions) {
  folder.precompute();
  const Outcome run = calot_run(
      {"cut", folder.model(), folder.compliance(), "--plane", "-20.3mm,0,0,-1,0,0", "-o", folder.name("cut")});
  EXPECT_EQ(run.code, 0) << run.err;
}

TEST_F(CutCall, WrongForces) {
  folder.precompute();
  const auto solve = [&](const std::string& force) {
    return calot_run({"solve", folder.model(), folder.compliance(), "--force", force, "-o", folder.name("u.csv")});
  };
  expect_refused(solve("389,0,0,1"), 2, {"vertex 389", "0 to 388"});
  expect_refused(solve("-1,0,0,1"), 2, {"vertex number"});
  expect_refused(solve("1.5,0,0,1"), 2, {"vertex number"});
  expect_refused(solve("3,0,1"), 2, {"3 values, not 4"});
  expect_refused(solve("3,0,0,inf"), 2, {"inf"});
  EXPECT_FALSE(std::filesystem::exists(folder.name("u.csv")));
  EXPECT_NE(solve("0,0,0,1").code, 2);
}

TEST_F(CutCall, ForcesOnVerticesThatTheCutRemoves) {
  folder.precompute();
  // Close planes leave some vertices without tets; the map of such a cut names them.
  const std::vector<std::string> planes{"--plane",        "40mm,0,0,1,0,0", "--plane",
                                        "43mm,0,0,1,0,0", "--plane",        "47mm,0,0,1,0,0"};
  std::vector<std::string> cut{"cut", folder.model(), folder.compliance(), "-o", folder.name("cut")};
  cut.insert(cut.end(), planes.begin(), planes.end());
  ASSERT_EQ(calot_run(cut).code, 0);
  const std::string map = read_bytes(folder.name("cut/vertex_map.csv"));
  const std::size_t gone = map.find(",-1\n");
  ASSERT_NE(gone, std::string::npos);
  const std::size_t start = map.rfind('\n', gone) + 1;
  const std::string vertex = map.substr(start, gone - start);
  std::vector<std::string> compare{"compare", folder.model(), "--force", vertex + ",0,0,1", "-o", folder.name("cmp")};
  compare.insert(compare.end(), planes.begin(), planes.end());
  expect_refused(calot_run(compare), 2, {"vertex " + vertex, "removed by the cut"});
  EXPECT_FALSE(std::filesystem::exists(folder.name("cmp")));
}

TEST_F(CutCall, WrongOutputs) {
  const Outcome nowhere = calot_run({"precompute", folder.model(), "-o", folder.name("no/such/C.h5")});
  expect_refused(nowhere, 2, {"no/such", "does not exist"});
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.path().string()}), 2, {"is a folder"});
  expect_refused(
      calot_run({"solve", folder.model(), folder.compliance(), "--force", "1,0,0,1", "-o", folder.name("u.xls")}), 2,
      {".xls"});
  expect_refused(calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.mesh()}), 2,
                 {"not a folder"});
  expect_refused(
      calot_run({"precompute", folder.model(), "-o", folder.compliance(), "--backend", "sparse", "--float32"}), 2,
      {"--float32"});
}

}  // namespace
}  // namespace calot::test
