// Tables of poses: any order of columns, and every mistake with its line.
#include "calot/scene/pose_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/files.h"

namespace calot::test {
namespace {

InstrumentScript read_text(const std::string& text) {
  const TempFolder folder;
  write_bytes(folder / "poses.csv", text);
  return read_poses(folder / "poses.csv", 1e-3);
}

TEST(PoseFile, ReadsColumnsInAnyOrder) {
  const InstrumentScript script =
      read_text("x,y,z,time,qw,qx,qy,qz,opening,energy\r\n1, 2 ,3,0,1,0,0,0,90,1\n\n4,5,6,0.5,0,0,0,1,0,0\n");
  ASSERT_EQ(script.poses.size(), 2u);
  EXPECT_LT((script.poses[0].pose.position - Vec3(1e-3, 2e-3, 3e-3)).norm(), 1e-18);
  EXPECT_NEAR(script.poses[0].opening, M_PI / 2, 1e-15);
  EXPECT_TRUE(script.poses[0].energy);
  EXPECT_FALSE(script.poses[0].fire);
  EXPECT_EQ(script.poses[1].time, 0.5);
  EXPECT_EQ(script.poses[1].pose.rotation.z(), 1);
}

TEST(PoseFile, SaysWhatIsWrongAndWhere) {
  const std::string header = "time,x,y,z,qw,qx,qy,qz\n";
  const auto message = [](const std::string& text) { return message_of([&] { (void)read_text(text); }); };
  const auto says = [&](const std::string& text, const std::string& line, const std::string& what) {
    const std::string found = message(text);
    EXPECT_NE(found.find("poses.csv" + line), std::string::npos) << found;
    EXPECT_NE(found.find(what), std::string::npos) << found;
  };
  says("", "", "no poses");
  says(header, "", "no poses");
  says("time,x,y,z,qw,qx,qy\n", ":1", "qz is missing");
  says("time,x,y,z,qw,qx,qy,qz,oppening\n", ":1", "opening");
  says("time,x,x\n", ":1", "twice");
  says(header + "0,0,0,0,1,0,0\n", ":2", "7 values for 8");
  says(header + "0,0,0,nan,1,0,0,0\n", ":2", "finite");
  says(header + "0,0,0,1e999,1,0,0,0\n", ":2", "finite");
  says(header + "0,0,zero,0,1,0,0,0\n", ":2", "zero");
  says(header + "0,0,0,0,1,1,0,0\n", ":2", "no rotation");
  says(header + "0,0,0,0,0,0,0,0\n", ":2", "no rotation");
  says(header + "0,0,0,1e6,1,0,0,0\n", ":2", "out of range");
  says(header + "-1,0,0,0,1,0,0,0\n", ":2", "out of range");
  says(header + "1,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n", ":3", "doesn't grow");
}

}  // namespace
}  // namespace calot::test
