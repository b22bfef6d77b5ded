#include "calot/patient/centreline_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace {

using namespace calot;
using namespace calot::test;

std::vector<Centreline> read_text(const std::string& name, const std::string& text) {
  TempFolder folder;
  write_bytes(folder / name, text);
  return read_centrelines(folder / name);
}

std::vector<Centreline> some_lines() {
  Random random(11);
  std::vector<Centreline> lines{{"cystic duct", {}, {}}, {"Common \"bile\" duct", {}, {}}};
  for (Centreline& line : lines)
    for (int p = 0; p < 12; ++p) {
      line.points.emplace_back(0.01 * p + 1e-4 * random.unit(), 0.1 + 1e-3 * random.unit(),
                               -0.3 * random.unit() * 1e-2);
      line.radii.push_back(random.between(0.3e-3, 14e-3));
    }
  return lines;
}

void expect_same(const std::vector<Centreline>& a, const std::vector<Centreline>& b, double tolerance = 1e-9) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t l = 0; l < a.size(); ++l) {
    EXPECT_EQ(a[l].name, b[l].name);
    ASSERT_EQ(a[l].points.size(), b[l].points.size());
    ASSERT_EQ(a[l].radii.size(), b[l].radii.size());
    for (std::size_t p = 0; p < a[l].points.size(); ++p) {
      EXPECT_LE((a[l].points[p] - b[l].points[p]).norm(), tolerance);
      EXPECT_NEAR(a[l].radii[p], b[l].radii[p], tolerance);
    }
  }
}

TEST(CentrelineFile, MarkupsReadBackToTheNanometre) {
  TempFolder folder;
  write_markups(folder / "a.mrk.json", some_lines());
  const std::vector<Centreline> again = read_centrelines(folder / "a.mrk.json");
  expect_same(some_lines(), again);
  write_markups(folder / "b.mrk.json", again);
  EXPECT_EQ(read_bytes(folder / "a.mrk.json"), read_bytes(folder / "b.mrk.json"));
}

/// What 3D Slicer saves: LPS, its own measurements first, a point that isn't placed yet.
std::string slicer_file(const std::string& measurement, const std::string& system = "\"LPS\"") {
  return R"({"@schema": "https://raw.githubusercontent.com/…/markups-schema-v1.0.3.json#",
 "markups": [{"type": "Curve", "coordinateSystem": )" +
         system + R"(, "coordinateUnits": ["mm", "UCUM"],
   "name": "cystic duct", "locked": false,
   "controlPoints": [
     {"id": "1", "label": "C-1", "position": [-10.5, 20, 30], "positionStatus": "defined"},
     {"id": "2", "label": "C-2", "position": [0, 0, 0], "positionStatus": "undefined"},
     {"id": "3", "label": "C-3", "position": [-12.5, 22.0, 4.0e1]}],
   "measurements": [{"name": "length", "enabled": false, "value": 10.4, "units": "mm"},
                    {"name": "curvature mean", "enabled": false}, )" +
         measurement + "]}]}";
}

TEST(CentrelineFile, ReadsWhatSlicerSaves) {
  const std::vector<Centreline> wanted{
      {"cystic duct", {{0.0105, -0.020, 0.030}, {0.0125, -0.022, 0.040}}, {1.5e-3, 2e-3}}};
  expect_same(wanted,
              read_text("a.mrk.json", slicer_file(R"({"name": "Radius", "controlPointValues": [1.5, 9, 2.0]})")));
  expect_same(wanted, read_text("a.mrk.json", slicer_file(R"({"name": "diameter", "units": "mm",
                                                              "controlPointValues": [3, 9, 4]})")));
  auto constant = wanted;
  constant[0].radii = {1.25e-3, 1.25e-3};
  expect_same(constant, read_text("a.mrk.json", slicer_file(R"({"name": "radius", "value": 1.25})")));
  expect_same(constant, read_text("a.mrk.json", slicer_file(R"({"name": "Diameter", "value": 2.5})")));
  auto turned = wanted;
  for (Vec3& p : turned[0].points) p = Vec3(-p.x(), -p.y(), p.z());
  const std::string radius = R"({"name": "radius", "controlPointValues": [1.5, 9, 2.0]})";
  expect_same(turned, read_text("a.mrk.json", slicer_file(radius, "\"RAS\"")));
  expect_same(turned, read_text("a.mrk.json", slicer_file(radius, "0")));
  expect_same(wanted, read_text("a.mrk.json", slicer_file(radius, "1")));
}

TEST(CentrelineFile, ReadsTextTables) {
  const std::vector<Centreline> wanted{
      {"cystic duct", {{0.0125, -0.003, 0.041}, {0.0135, 0.003, 0.040}}, {1.4e-3, 1.5e-3}},
      {"cystic artery", {{0, 0, 0}, {0.001, 0, 0}}, {0.6e-3, 0.6e-3}}};
  expect_same(wanted, read_text("a.txt",
                                "# by hand\n\nline cystic duct   # the thin one\n12.5 -3.0 41.0 1.4\n"
                                "  13.5\t+3 4.0e1 1.5 # end\nline cystic artery\n0 0 0 0.6\n1 0 0 0.6"));
  expect_same(wanted, read_text("a.csv",
                                "\xEF\xBB\xBFline, cystic duct\r\n12.5,-3.0,41.0,1.4\r\n13.5, 3, 40, 1.5\r\n"
                                "line,cystic artery\r\n0;0;0;0.6\r\n1;0;0;0.6\r\n"));
}

struct Mistake {
  std::string text, message;
};

TEST(CentrelineFile, NamesLineAndCureInTextTables) {
  const std::vector<Mistake> mistakes{
      {"1 2 3 4\n", "a.txt:1: a point before the first \"line\""},
      {"line\n", "a.txt:1: \"line\" without a name"},
      {"line -- #\n1 2 3 1\n2 2 3 1\n", "a.txt:1: a centreline without a name"},
      {"line a\n1 2 3\n", "a.txt:2: 3 numbers where four belong; write x y z radius, with decimal points"},
      {"line a\n12,5 -3,0 41,0 1,4\n", "a.txt:2: 8 numbers where four belong"},
      {"line a\n\nx y z radius\n", "a.txt:3: \"x\" is not a number"},
      {"line a\n1 2 3 1e999\n", "a.txt:2: \"1e999\" is not a number"},
      {"line a\n1 2 3 nan\n", "a.txt:2: \"nan\" is not a number"},
      {"line a\n1 2 3 1\n", "a.txt:1: \"a\" has fewer than two points; draw it longer"},
      {"line a\n1 2 3 1\n1 2 3 1\n", "a.txt:3: the point is at the same place as the one before it"},
      {"line a\n1 2 3 1\n1 2 64 1\n", "a.txt:3: the point is 61 mm away from the one before it; put points between"},
      {"line a\n1 2 3 0.1\n1 2 4 1\n", "a.txt:2: radius 0.1 mm is not that of a duct or an artery; give 0.2 to 15 mm"},
      {"line a\n1 2 3 15.1\n1 2 4 1\n", "a.txt:2: radius 15.1 mm is not"},
      {"line a\n1 2 3 1\n1 2 4 -1\n", "a.txt:3: radius -1 mm is not"},
      {"line a\n1 2 20000 1\n1 2 20001 1\n", "a.txt:2: a point at (1, 2, 20000) mm is in no body"},
      {"line cystic duct\n1 2 3 1\n1 2 4 1\nline Cystic_Duct\n1 2 3 1\n1 2 4 1\n",
       "a.txt:4: a second centreline named \"Cystic_Duct\""},
      {"# nothing\n", "a.txt: has no centreline"},
      {std::string("line a\n\0\0\0\0", 11), "is not a number"},
  };
  for (const Mistake& mistake : mistakes) {
    const std::string message = message_of([&] { read_text("a.txt", mistake.text); });
    EXPECT_NE(message.find(mistake.message), std::string::npos) << mistake.text << "\ngave: " << message;
  }
  EXPECT_NE(message_of([] { read_text("a.vtp", ""); }).find("use .mrk.json (3D Slicer markups), .txt or .csv"),
            std::string::npos);
}

TEST(CentrelineFile, NamesFieldAndCureInMarkups) {
  const std::string good = slicer_file(R"({"name": "radius", "controlPointValues": [1.5, 9, 2.0]})");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::vector<Mistake> mistakes{
      {"", "a.mrk.json:1: not JSON"},
      {"{\n\n  \"markups\": [}", "a.mrk.json:3: not JSON"},
      {"[1e999]", "not JSON"},
      {std::string(100000, '['), "is nested too deeply"},
      {"{\"markups\":" + std::string(100000, '[') + std::string(100000, ']') + "}", "is nested too deeply"},
      {"[]", "holds no list \"markups\""},
      {"{\"markups\": {}}", "holds no list \"markups\""},
      {"{\"markups\": []}", "has no centreline; draw an open curve"},
      {"{\"markups\": [3]}", "markups[0]: is not a markup"},
      {changed("\"Curve\"", "\"Fiducial\""), "markups[0].type: \"Fiducial\" is not an open curve"},
      {changed("\"Curve\"", "\"ClosedCurve\""), "\"ClosedCurve\" is not an open curve"},
      {changed("\"LPS\"", "\"IJK\""), "markups[0].coordinateSystem: is neither"},
      {changed("[\"mm\", \"UCUM\"]", "\"cm\""), "markups[0].coordinateUnits: is not \"mm\""},
      {changed("[-10.5, 20, 30]", "[-10.5, 20]"), "markups[0].controlPoints[0].position: doesn't hold three numbers"},
      {changed("[-10.5, 20, 30]", "[-10.5, 20, \"30\"]"), "controlPoints[0].position: is not a number"},
      {changed("[-10.5, 20, 30]", "null"), "controlPoints[0].position: is missing or not a list"},
      {changed("[-10.5, 20, 30]", "[1e300, 20, 30]"), "controlPoints[0]: a point at"},
      {changed("\"radius\"", "\"thickness\""),
       "markups[0].measurements: \"cystic duct\" has no radius; add a measurement"},
      {changed("[1.5, 9, 2.0]", "[1.5, 2.0]"),
       "measurements[2].controlPointValues: doesn't hold one number a control point, 3"},
      {changed("[1.5, 9, 2.0]", "[1.5, 9, null]"), "controlPointValues: is not a number"},
      {changed("[1.5, 9, 2.0]", "[0, 9, 2.0]"), "controlPoints[0]: radius 0 mm"},
      {changed("\"name\": \"cystic duct\"", "\"name\": 3"), "markups[0].name: is not text"},
      {changed("\"positionStatus\": \"defined\"", "\"positionStatus\": \"preview\""), "has fewer than two points"},
  };
  for (const Mistake& mistake : mistakes) {
    const std::string message = message_of([&] { read_text("a.mrk.json", mistake.text); });
    EXPECT_NE(message.find(mistake.message), std::string::npos)
        << mistake.text.substr(0, 2000) << "\ngave: " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

}  // namespace
