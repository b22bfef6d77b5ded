// Every key of a scene file arrives where it belongs, in SI; what is written reads back.
#include "calot/scene/scene_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "calot/scene/region_figures.h"
#include "tests/support/files.h"

namespace calot::test {
namespace {

Scene read_text(const std::string& text) {
  const TempFolder folder;
  write_bytes(folder / "s.toml", text);
  return read_scene(folder / "s.toml");
}

std::string written(const Scene& scene) {
  std::ostringstream out;
  write_scene(out, scene);
  return out.str();
}

const char* const whole = R"(title = "All keys"
length_unit = "mm"
time_step = 0.01
seconds = 2.0
seed = 7
gravity = [0, -9.81, 0]
rayleigh_mass = 0.5
rayleigh_stiffness = 0.001
cutting = "remove"
tearing = false
heat = false
fluids = false
[[block]]
region = "liver"
centre = [1, 2, 3]
size = [40, 20, 10]
element_size = 5
fixed = ["x-", "z+"]
[[tube]]
points = [[0, 0, 50], [30, 0, 50], [60, 0, 60]]
radii = [2, 2, 6]
regions = ["cystic duct", "gallbladder"]
rings = 3
fixed = ["last"]
[[tube]]
region = "cystic artery"
points = [[0, 0, 90], [30, 0, 90]]
radius = 1
[[region]]
region = "*"
friction = 0.2
[[region]]
region = "liver"
body = "rigid"
carried = true
young = 4000
outer_radius = 1.5
[[floor]]
name = "table"
point = [0, 0, -20]
normal = [0, 0, 2]
size = 500
friction = 0.4
[[surface]]
file = "wall.stl"
length_unit = "cm"
friction = 0.5
[[instrument]]
name = "left"
kind = "curved forceps"
port = [100, 0, 150]
friction = 0.15
max_grip = 9
keyframes = [ { time = 0.5, tip = [0, 0, 20], roll = 90, opening = 30, grip = 1 },
              { time = 1, tip = [5, 0, 20], energy = true, fire = true } ]
[[instrument]]
name = "right"
kind = "hook"
direction = [0, 0, -3]
power = 45
keyframes = [ { time = 0, tip = [0, 0, 30] }, { time = 1, direction = [1, 0, 0] } ]
[contact]
tissue_friction = 0.05
self_contact = false
max_contacts = 30
[haptics]
instrument = "left"
stiffness = 800
damping = 2
max_force = 4
[camera]
eye = [0, -100, 20]
target = [0, 0, 0]
up = [0, 0, 2]
)";

TEST(SceneFile, GeneralKeys) {
  const Scene s = read_text(whole);
  EXPECT_EQ(s.title, "All keys");
  EXPECT_EQ(s.time_step, 0.01);
  EXPECT_EQ(s.steps, 200u);
  EXPECT_EQ(s.seed, 7u);
  EXPECT_EQ(s.gravity, Vec3(0, -9.81, 0));
  EXPECT_EQ(s.rayleigh_mass, 0.5);
  EXPECT_EQ(s.rayleigh_stiffness, 0.001);
  EXPECT_EQ(s.cutting, CuttingMode::remove);
  EXPECT_FALSE(s.tearing || s.heat || s.fluids);
  EXPECT_EQ(s.tissue_friction, 0.05);
  EXPECT_FALSE(s.self_contact);
  EXPECT_EQ(s.max_contacts, 30);
  EXPECT_EQ(s.haptics.instrument, "left");
  EXPECT_EQ(s.haptics.stiffness, 800);
  EXPECT_EQ(s.haptics.damping, 2);
  EXPECT_EQ(s.haptics.max_force, 4);
  ASSERT_TRUE(s.camera);
  EXPECT_LT((s.camera->eye - Vec3(0, -0.1, 0.02)).norm(), 1e-12);
  EXPECT_EQ(s.camera->up, Vec3::UnitZ());
}

TEST(SceneFile, ShapesAndRegions) {
  const Scene s = read_text(whole);
  ASSERT_EQ(s.blocks.size(), 1u);
  EXPECT_EQ(s.blocks[0].region, "liver");
  EXPECT_LT((s.blocks[0].centre - Vec3(1e-3, 2e-3, 3e-3)).norm(), 1e-17);
  EXPECT_LT((s.blocks[0].size - Vec3(0.04, 0.02, 0.01)).norm(), 1e-17);
  EXPECT_NEAR(s.blocks[0].element_size, 0.005, 1e-17);
  EXPECT_EQ(s.blocks[0].fixed, (std::array<bool, 6>{true, false, false, false, false, true}));
  ASSERT_EQ(s.tubes.size(), 2u);
  EXPECT_EQ(s.tubes[0].points.size(), 3u);
  EXPECT_EQ(s.tubes[0].regions, (std::vector<std::string>{"cystic duct", "gallbladder"}));
  EXPECT_NEAR(s.tubes[0].radii[2], 0.006, 1e-17);
  EXPECT_EQ(s.tubes[0].rings, 3);
  EXPECT_FALSE(s.tubes[0].fixed_first);
  EXPECT_TRUE(s.tubes[0].fixed_last);
  EXPECT_EQ(s.tubes[1].regions, (std::vector<std::string>{"cystic artery"}));
  EXPECT_EQ(s.tubes[1].radii, (std::vector<double>{1e-3, 1e-3}));
  ASSERT_EQ(s.regions.size(), 2u);
  EXPECT_EQ(s.regions[0].figures.at("friction"), 0.2);
  EXPECT_FALSE(s.regions[0].body);
  EXPECT_FALSE(s.regions[0].carried);
  EXPECT_EQ(s.regions[1].body, BodyKind::rigid);
  EXPECT_EQ(s.regions[1].carried, true);
  EXPECT_EQ(s.regions[1].figures.at("young"), 4000);
  EXPECT_NEAR(s.regions[1].figures.at("outer_radius"), 0.0015, 1e-17);
}

TEST(SceneFile, StillSurfaces) {
  const Scene s = read_text(whole);
  ASSERT_EQ(s.surfaces.size(), 2u);
  EXPECT_EQ(s.surfaces[0].name, "table");
  EXPECT_EQ(s.surfaces[0].point, Vec3(0, 0, -20e-3));
  EXPECT_EQ(s.surfaces[0].normal, Vec3(0, 0, 1));
  EXPECT_EQ(s.surfaces[0].size, 0.5);
  EXPECT_EQ(s.surfaces[0].friction, 0.4);
  EXPECT_EQ(s.surfaces[1].name, "wall");
  EXPECT_EQ(s.surfaces[1].file.filename(), "wall.stl");
  EXPECT_EQ(s.surfaces[1].scale, 0.01);
  EXPECT_EQ(s.surfaces[1].friction, 0.5);
}

TEST(SceneFile, Instruments) {
  const Scene s = read_text(whole);
  ASSERT_EQ(s.instruments.size(), 2u);
  const SceneInstrument &left = s.instruments[0], &right = s.instruments[1];
  EXPECT_EQ(left.kind, InstrumentKind::curved_forceps);
  EXPECT_EQ(*left.port, Vec3(0.1, 0, 0.15));
  EXPECT_EQ(left.friction, 0.15);
  EXPECT_EQ(left.max_grip, 9);
  ASSERT_EQ(left.script.keys.size(), 2u);
  EXPECT_NEAR(left.script.keys[0].roll, M_PI / 2, 1e-15);
  EXPECT_NEAR(left.script.keys[0].opening, M_PI / 6, 1e-15);
  EXPECT_FALSE(left.script.keys[0].energy);
  // What a keyframe leaves out stays.
  EXPECT_EQ(left.script.keys[1].opening, left.script.keys[0].opening);
  EXPECT_EQ(left.script.keys[1].grip, 1);
  EXPECT_TRUE(left.script.keys[1].energy && left.script.keys[1].fire);
  EXPECT_EQ(right.power, 45);
  EXPECT_FALSE(right.port || right.friction || right.max_grip);
  EXPECT_EQ(right.script.keys[0].direction, Vec3(0, 0, -1));
  EXPECT_EQ(right.script.keys[1].direction, Vec3(1, 0, 0));
}

TEST(SceneFile, Defaults) {
  const Scene s = read_text("[[block]]\nsize = [1, 1, 1]\nelement_size = 0.5\n"), d;
  EXPECT_EQ(s.time_step, 1.0 / 60);
  EXPECT_EQ(s.gravity, Vec3(0, 0, -9.81));
  EXPECT_EQ(s.steps, 0u);
  EXPECT_TRUE(s.tearing && s.heat && s.fluids && s.self_contact);
  EXPECT_EQ(s.cutting, CuttingMode::split);
  EXPECT_EQ(s.blocks[0].size, Vec3(1, 1, 1));
  EXPECT_EQ(s.blocks[0].region, "tissue");
  EXPECT_EQ(s.max_contacts, d.max_contacts);
}

TEST(SceneFile, RunsAsLongAsItsScriptsUnlessItSays) {
  const std::string text =
      "[[block]]\nsize = [1, 1, 1]\nelement_size = 0.5\n[[instrument]]\nname = \"a\"\nkind = \"hook\"\n"
      "keyframes = [{ time = 0, tip = [0, 0, 1] }, { time = 2 }]\n";
  EXPECT_EQ(read_text(text).steps, 120u);
  EXPECT_EQ(read_text("steps = 17\n" + text).steps, 17u);
  EXPECT_EQ(read_text("seconds = 0.5\n" + text).steps, 30u);
}

TEST(SceneFile, ReadsBackTheSame) {
  const TempFolder folder;
  write_bytes(folder / "a.toml", whole);
  const Scene a = read_scene(folder / "a.toml");
  write_bytes(folder / "b.toml", written(a));
  const Scene b = read_scene(folder / "b.toml");
  EXPECT_EQ(written(b), written(a));
  EXPECT_EQ(b.steps, a.steps);
  EXPECT_EQ(b.blocks[0].centre, a.blocks[0].centre);
  EXPECT_EQ(b.surfaces[1].file, a.surfaces[1].file);
  EXPECT_EQ(b.regions[1].figures, a.regions[1].figures);
  for (const double t : {0.0, 0.6, 0.77, 3.0})
    EXPECT_EQ(input_at(b.instruments[0].script, 0.02, b.instruments[0].port, t).pose.position,
              input_at(a.instruments[0].script, 0.02, a.instruments[0].port, t).pose.position);
}

TEST(SceneFile, EveryFigureOfARegionIsReadAndWritten) {
  for (const detail::RegionFigure& figure : detail::region_figures()) {
    const double value = figure.low + 0.25 * (figure.high - figure.low);
    const Scene s = read_text("[[block]]\nsize = [1, 1, 1]\nelement_size = 0.5\n[[region]]\nregion = \"*\"\n" +
                              std::string(figure.key) + " = " + detail::toml_real(value) + "\n");
    ASSERT_EQ(s.regions.size(), 1u);
    EXPECT_EQ(s.regions[0].figures.at(figure.key), value) << figure.key;
    EXPECT_EQ(written(read_text(written(s))), written(s));
  }
}

TEST(SceneFile, PosesComeFromATable) {
  const TempFolder folder;
  write_bytes(folder / "p.csv", "time,x,y,z,qw,qx,qy,qz\n0,10,0,0,1,0,0,0\n1,20,0,0,1,0,0,0\n");
  write_bytes(folder / "s.toml",
              "length_unit = \"mm\"\npatient = \"p7\"\n[[instrument]]\nname = \"a\"\nkind = \"scissors\"\nposes = "
              "\"p.csv\"\n[[instrument]]\nname = \"b\"\nkind = \"scissors\"\nport = \"epigastric\"\nkeyframes = [{ "
              "time = 0, tip = [0, 0, 0] }]\n");
  const Scene s = read_scene(folder / "s.toml");
  EXPECT_EQ(s.patient, folder / "p7");
  ASSERT_EQ(s.instruments[0].script.poses.size(), 2u);
  EXPECT_EQ(s.instruments[0].script.poses[1].pose.position.x(), 20 * 1e-3);
  EXPECT_EQ(s.steps, 60u);
  EXPECT_EQ(s.instruments[1].port_name, "epigastric");
}

}  // namespace
}  // namespace calot::test
