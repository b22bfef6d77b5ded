// Everything that can be wrong with model.toml: exit code 2, file and line.
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace calot::test {
namespace {

/// One mistake: what to write instead of what, the line it is on, and words that must be said.
struct Mistake {
  std::string from, to;
  int line;
  std::vector<std::string> words;
};

const std::string sound = R"(mesh = "organ.msh"
length_unit = "m"
region_names = { 2 = "gallbladder", 3 = "cystic duct" }
time_step = 0.02
rayleigh_mass = 0
rayleigh_stiffness = 0.0
mass_lumping = "element"

[[material]]
region = "*"
young = 1.0e6
poisson = 0.45
density = 1000

[[fixed]]
box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }
)";

class BadModel : public testing::TestWithParam<Mistake> {
 protected:
  ModelFolder folder;
};

TEST_P(BadModel, IsRefusedWithFileAndLine) {
  const Mistake& mistake = GetParam();
  write_bytes(folder.model(), sound);
  folder.edit_model(mistake.from, mistake.to);
  std::vector<std::string> words = mistake.words;
  words.push_back(mistake.line > 0 ? folder.model() + ":" + std::to_string(mistake.line) + ": "
                                   : folder.model() + ": ");
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}), 2, words);
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"model.toml", "organ.msh"}));
}

INSTANTIATE_TEST_SUITE_P(
    Keys, BadModel,
    testing::Values(
        Mistake{"young = ", "yuong = ", 11, {"yuong", "did you mean young?"}},
        Mistake{"rayleigh_mass", "raleigh_mass", 5, {"did you mean rayleigh_mass?"}},
        Mistake{"time_step", "colour = 3\ntime_step", 4, {"unknown key \"colour\"", "there are: mesh"}},
        Mistake{"box =", "boxes =", 16, {"did you mean box?"}}, Mistake{"min =", "minimum =", 16, {"unknown key"}},
        Mistake{"mesh = \"organ.msh\"", "", 1, {"\"mesh\" is missing"}},
        Mistake{"young = 1.0e6\n", "", 9, {"\"young\" is missing"}},
        Mistake{"region = \"*\"\n", "", 9, {"\"region\" is missing"}},
        Mistake{"box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }", "", 15, {"needs one of vertices, box and region"}},
        Mistake{"min = [0, 0, 0.058], ", "", 16, {"\"min\" is missing"}},
        Mistake{"time_step = 0.02", "time_step = 0.02\ntime_step = 0.03", 5, {"not TOML"}}));

INSTANTIATE_TEST_SUITE_P(
    Values, BadModel,
    testing::Values(
        Mistake{"1.0e6", "0", 11, {"young = 0 must be > 0"}}, Mistake{"1.0e6", "-5e3", 11, {"young = -5000"}},
        Mistake{"1.0e6", "nan", 11, {"young", "finite"}}, Mistake{"1.0e6", "\"stiff\"", 11, {"young must be a number"}},
        Mistake{"0.45", "0.5", 12, {"poisson = 0.5", "between -1 and 0.5"}},
        Mistake{"0.45", "-1", 12, {"poisson = -1"}}, Mistake{"0.45", "inf", 12, {"finite"}},
        Mistake{"= 1000", "= 0", 13, {"density = 0 must be > 0"}},
        Mistake{"= 0.02", "= -0.02", 4, {"time_step = -0.02"}}, Mistake{"= 0.02", "= nan", 4, {"time_step", "finite"}},
        Mistake{"rayleigh_mass = 0", "rayleigh_mass = -1", 5, {"rayleigh_mass = -1"}},
        Mistake{"\"m\"", "\"inch\"", 2, {"inch"}}, Mistake{"\"m\"", "3", 2, {"length_unit must be text"}},
        Mistake{"\"element\"", "\"lumpy\"", 7, {"lumpy", "uniform"}},
        Mistake{"\"element\"", "\"element\"\ntotal_mass = 2", 8, {"total_mass needs mass_lumping"}},
        Mistake{"\"element\"", "\"uniform\"\ntotal_mass = 0", 8, {"total_mass = 0"}},
        Mistake{"organ.msh", "heart.msh", 1, {"no mesh file", "heart.msh"}},
        Mistake{"organ.msh", ".", 1, {"no mesh file"}}, Mistake{"\"organ.msh\"", "7", 1, {"mesh must be text"}}));

INSTANTIATE_TEST_SUITE_P(Regions, BadModel,
                         testing::Values(Mistake{"\"*\"", "\"spleen\"", 10, {"spleen", "2 (gallbladder)"}},
                                         Mistake{"\"*\"", "9", 10, {"\"9\"", "2 (gallbladder)"}},
                                         Mistake{"\"*\"", "true", 10, {"region must be text"}},
                                         Mistake{"\"*\"", "2", 0, {"region 3 (cystic duct) has no material"}},
                                         Mistake{"2 = \"gall", "8 = \"gall", 3, {"\"8\""}},
                                         Mistake{"2 = \"gallbladder\"", "two = \"gallbladder\"", 3, {"two"}},
                                         Mistake{"\"gallbladder\"", "2", 3, {"must be text"}}));

INSTANTIATE_TEST_SUITE_P(
    Supports, BadModel,
    testing::Values(
        Mistake{
            "box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }", "vertices = [0, 389]", 16, {"vertex 389", "0 to 388"}},
        Mistake{"box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }", "vertices = [-1]", 16, {"vertex -1"}},
        Mistake{"box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }", "vertices = [1.5]", 16, {"whole number"}},
        Mistake{"box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }", "vertices = 3", 16, {"must be a list"}},
        Mistake{"box = { min = [0, 0, 0.058], max = [0.02, 1, 1] }", "region = \"spleen\"", 16, {"spleen"}},
        Mistake{"0.058", "2.0", 16, {"the box is empty"}}, Mistake{"1, 1]", "1, nan]", 16, {"finite"}},
        Mistake{"[0, 0, 0.058]", "[0, 0]", 16, {"three numbers"}},
        Mistake{"max = [0.02, 1, 1]", "max = [0.02, 1, 0.0581]", 16, {"catches no vertex", "the mesh reaches from"}},
        Mistake{"[[fixed]]\nbox = { min = [0, 0, 0.058], max = [0.02, 1, 1] }",
                "[fixed]\nregion = \"2\"",
                15,
                {"list of tables"}},
        Mistake{"time_step = 0.02", "fixed = 3\ntime_step = 0.02", 16, {"not TOML"}}));

INSTANTIATE_TEST_SUITE_P(Syntax, BadModel,
                         testing::Values(Mistake{"0.02", "0.02.3", 4, {"not TOML"}},
                                         Mistake{"\"organ.msh\"", "\"organ.msh", 1, {"not TOML"}},
                                         Mistake{"[[material]]", "[[material", 9, {"not TOML"}},
                                         Mistake{"mesh = ", std::string(100, '['), 0, {"nested too deeply"}}));

TEST(Model, OfAStaticKindNeedsSupport) {
  const ModelFolder folder;
  write_bytes(folder.model(),
              "mesh = \"organ.msh\"\n\ntime_step = 0\n[[material]]\nregion = \"*\"\nyoung = 1\npoisson = 0\n");
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}), 2,
                 {folder.model() + ":3: ", "static", "fixed"});
  EXPECT_FALSE(std::filesystem::exists(folder.compliance()));
}

TEST(Model, MissingEmptyOrAFolder) {
  const ModelFolder folder;
  expect_refused(calot_run({"precompute", folder.name("no.toml"), "-o", folder.compliance()}), 2,
                 {"no.toml", "no such file"});
  expect_refused(calot_run({"precompute", folder.path().string(), "-o", folder.compliance()}), 2, {"is a folder"});
  write_bytes(folder.model(), "");
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}), 2, {"\"mesh\" is missing"});
  write_bytes(folder.model(), std::string("\0\xff\xfe garbage \x80", 14));
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}), 2, {folder.model()});
  EXPECT_FALSE(std::filesystem::exists(folder.compliance()));
}

}  // namespace
}  // namespace calot::test
