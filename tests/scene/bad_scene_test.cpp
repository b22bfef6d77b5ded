// Every mistake in a scene file is one line that names file and line, says what is wrong and what to do.
#include <gtest/gtest.h>

#include "calot/scene/scene_file.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

/// Text of a scene that is right, on lines 1 to 3; what is added begins at line 4.
const std::string sound = "[[block]]\nsize = [1, 1, 1]\nelement_size = 0.5\n";
const std::string tool = "[[instrument]]\nname = \"a\"\nkind = \"hook\"\n";  // 3 lines
const std::string keys = "keyframes = [{ time = 0, tip = [0, 0, 0] }]\n";

struct Case {
  std::string text;
  int line;  // 0: the file alone
  std::string what;
};

class BadScene : public testing::TestWithParam<Case> {};

TEST_P(BadScene, IsRefusedWithItsLine) {
  const TempFolder folder;
  write_bytes(folder / "s.toml", GetParam().text);
  const std::string found = message_of([&] { (void)read_scene(folder / "s.toml"); });
  const std::string where = GetParam().line == 0 ? "s.toml:" : "s.toml:" + std::to_string(GetParam().line) + ":";
  EXPECT_NE(found.find(where), std::string::npos) << found << "\n" << GetParam().text;
  EXPECT_NE(found.find(GetParam().what), std::string::npos) << found;
  EXPECT_EQ(found.find('\n'), std::string::npos) << found;
}

INSTANTIATE_TEST_SUITE_P(
    General, BadScene,
    testing::Values(Case{"", 0, "no tissue"}, Case{"= 1", 1, "not TOML"}, Case{"grafity = 1\n" + sound, 1, "gravity"},
                    Case{"patient = \"p\"\n" + sound, 0, "more than one place"},
                    Case{"patient = \"\"\n", 1, "is empty"}, Case{"time_step = 0\n" + sound, 1, "out of range"},
                    Case{"time_step = nan\n" + sound, 1, "finite"}, Case{"time_step = \"1\"\n" + sound, 1, "number"},
                    Case{"seed = -1\n" + sound, 1, "out of range"}, Case{"seed = 1.5\n" + sound, 1, "whole"},
                    Case{"gravity = [0, 0]\n" + sound, 1, "three"}, Case{"gravity = [0, 0, 981]\n" + sound, 1, "m/s2"},
                    Case{"gravity = [0, 0, inf]\n" + sound, 1, "finite"},
                    Case{"length_unit = \"inch\"\n" + sound, 1, "inch"}, Case{"steps = 0\n" + sound, 1, "out of range"},
                    Case{"seconds = 1\nsteps = 3\n" + sound, 1, "leave one out"},
                    Case{"rayleigh_mass = -1\n" + sound, 1, "out of range"},
                    Case{"cutting = \"splitt\"\n" + sound, 1, "split"}, Case{"heat = 1\n" + sound, 1, "true or false"},
                    Case{"title = 3\n" + sound, 1, "text"}, Case{"block = 3\n", 1, "[[block]]"}));

INSTANTIATE_TEST_SUITE_P(
    Shapes, BadScene,
    testing::Values(Case{"[[block]]\nelement_size = 1\n", 1, "\"size\" is missing"},
                    Case{"[[block]]\nsize = [1, 1, 1]\n", 1, "element_size"},
                    Case{"[[block]]\nsize = [1, 0, 1]\nelement_size = 1\n", 2, "no size"},
                    Case{"[[block]]\nsize = [1, 1, 20]\nelement_size = 1\n", 2, "10 m"},
                    Case{sound + "fixed = [\"top\"]\n", 4, "z+"}, Case{sound + "fixed = \"x-\"\n", 4, "list"},
                    Case{sound + "colour = 1\n", 4, "unknown key"}, Case{"[[tube]]\nradius = 1\n", 1, "points"},
                    Case{"[[tube]]\npoints = [[0,0,0]]\nradius = 0.1\n", 2, "two points"},
                    Case{"[[tube]]\npoints = [[0,0,0],[0,0,0]]\nradius = 0.1\n", 2, "same place"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\n", 1, "radius or radii"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\nradii = [0.1]\n", 3, "1 radii for 2"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\nradius = -0.1\n", 3, "out of range"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\nradius = 0.1\nregions = [\"a\", \"b\"]\n", 4,
                         "stretches"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\nradius = 0.1\nregion = \"a\"\nregions = [\"b\"]\n", 5,
                         "leave one out"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\nradius = 0.1\nrings = 0\n", 4, "out of range"},
                    Case{"[[tube]]\npoints = [[0,0,0],[1,0,0]]\nradius = 0.1\nfixed = [\"end\"]\n", 4, "last"}));

INSTANTIATE_TEST_SUITE_P(
    RegionsAndSurfaces, BadScene,
    testing::Values(Case{sound + "[[region]]\nyoung = 1e4\n", 4, "\"region\" is missing"},
                    Case{sound + "[[region]]\nregion = \"*\"\nyung = 1e4\n", 6, "young"},
                    Case{sound + "[[region]]\nregion = \"*\"\nyoung = 0\n", 6, "Pa"},
                    Case{sound + "[[region]]\nregion = \"*\"\npoisson = 0.5\n", 6, "out of range"},
                    Case{sound + "[[region]]\nregion = \"*\"\nouter_radius = 5\n", 6, "out of range"},
                    Case{sound + "[[region]]\nregion = \"*\"\nbody = \"still\"\n", 6, "static"},
                    Case{sound + "[[floor]]\nnormal = [0, 0, 0]\n", 5, "no direction"},
                    Case{sound + "[[floor]]\nsize = 0\n", 5, "out of range"},
                    Case{sound + "[[surface]]\nname = \"w\"\n", 4, "file"},
                    Case{sound + "[[surface]]\nfile = \"w.stl\"\nlength_unit = \"km\"\n", 6, "km"},
                    Case{sound + "[contact]\nmax_contacts = 0\n", 5, "out of range"},
                    Case{sound + "[contact]\nfriction = 0\n", 5, "tissue_friction"},
                    Case{sound + "[[contact]]\n", 4, "[contact]"},
                    Case{sound + "[camera]\neye = [0, 0, 0]\n", 4, "target"},
                    Case{sound + "[camera]\neye = [0, 0, 0.001]\nup = [1, 0, 0]\ntarget = [0, 0, 0]\n", 4, "5 mm"},
                    Case{sound + "[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n", 4, "up lies along"},
                    Case{sound + "[haptics]\nstiffness = 1\n", 4, "instrument"},
                    Case{sound + "[haptics]\ninstrument = \"a\"\n", 5, "[[instrument]]"},
                    Case{sound + tool + keys + "[haptics]\ninstrument = \"b\"\n", 9, "did you mean a?"}));

INSTANTIATE_TEST_SUITE_P(
    Instruments, BadScene,
    testing::Values(
        Case{sound + "[[instrument]]\nkind = \"hook\"\n", 4, "\"name\" is missing"},
        Case{sound + "[[instrument]]\nname = \"a\"\n", 4, "\"kind\" is missing"},
        Case{sound + "[[instrument]]\nname = \"a\"\nkind = \"sissors\"\n", 6, "did you mean scissors?"},
        Case{sound + tool, 4, "keyframes or poses"}, Case{sound + tool + keys + tool + keys, 8, "two instruments"},
        Case{sound + tool + "keyframes = []\n", 7, "no keyframes"},
        Case{sound + tool + "keyframes = [1]\n", 7, "must be a table"},
        Case{sound + tool + "keyframes = [{ tip = [0, 0, 0] }]\n", 7, "time"},
        Case{sound + tool + "keyframes = [{ time = 0 }]\n", 7, "tip"},
        Case{sound + tool + "keyframes = [{ time = 0, tip = [0, 0, 0] },\n{ time = 0 }]\n", 8, "doesn't grow"},
        Case{sound + tool + "keyframes = [{ time = 0, tip = [0, 0, nan] }]\n", 7, "finite"},
        Case{sound + tool + "keyframes = [{ time = 0, tip = [0, 0, 0], grip = -1 }]\n", 7, "out of range"},
        Case{sound + tool + "keyframes = [{ time = 0, tip = [0, 0, 0], opening = 200 }]\n", 7, "degrees"},
        Case{sound + tool + "keyframes = [{ time = 0, tip = [0, 0, 0], fire = 1 }]\n", 7, "true or false"},
        Case{sound + tool + "keyframes = [{ time = 0, tipp = [0, 0, 0] }]\n", 7, "did you mean tip?"},
        Case{sound + tool + "port = [0, 0, 0]\n" + keys, 8, "lies in its port"},
        Case{sound + tool + "port = \"epigastric\"\n" + keys, 7, "in a patient only"},
        Case{sound + tool + "port = [0, 0, 1]\ndirection = [0, 0, 1]\n" + keys, 7, "leave one out"},
        Case{sound + tool + "port = [0, 0, 1]\nkeyframes = [{ time = 0, tip = [0, 0, 0], direction = [0, 0, 1] }]\n", 8,
             "leave it out"},
        Case{sound + tool + "poses = \"nothing.csv\"\n", 7, "no file"},
        Case{sound + tool + "direction = [0, 0, 1]\nposes = \"nothing.csv\"\n", 7, "leave direction out"},
        Case{sound + tool + "poses = \".\"\n", 7, "no file"},
        Case{sound + tool + keys + "friction = -0.1\n", 8, "out of range"},
        Case{sound + tool + keys + "power = 1e9\n", 8, "W"}));

}  // namespace
}  // namespace calot::test
