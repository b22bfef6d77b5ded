// calot cut --mode split: what is written belongs together, keeps the volume, and answers as a recomputation does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <tuple>

#include "calot/compliance/compliance_file.h"
#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "calot/mesh/parts.h"
#include "calot/mesh/quality.h"
#include "tests/app/program.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

/// Across the gallbladder, well away from mesh planes.
const std::string middle_plane = "41.3mm,0,0,1,0.07,0.03";
/// Some way into the gallbladder only.
const std::vector<std::string> notch{"--blade", "40mm,15mm,40mm,1,0.02,0.05,0,1,0,60mm,20mm"};

Outcome split_run(const ModelFolder& folder, const std::vector<std::string>& more, const std::string& output) {
  std::vector<std::string> arguments{"cut",   folder.model(), folder.compliance(), "--mode",
                                     "split", "-o",           folder.name(output)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return calot_run(arguments);
}

/// The summary of a split that is expected to work.
nlohmann::json split(const ModelFolder& folder, const std::vector<std::string>& more, const std::string& output) {
  const Outcome run = split_run(folder, more, output);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err.find("calot: warning"), std::string::npos) << run.err;
  return nlohmann::json::parse(read_bytes(folder.name(output + "/summary.json")));
}

std::map<std::int32_t, double> volumes(const TetMesh& mesh) {
  std::map<std::int32_t, double> sums;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) sums[mesh.regions[t]] += signed_volume(mesh, TetId(t));
  return sums;
}

/// Reads a file of comma-separated numbers below the header.
std::vector<std::vector<double>> read_table(const std::string& path, const std::string& header) {
  std::istringstream in(read_bytes(path));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, header);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    rows.emplace_back();
    for (std::string word; std::getline(words, word, ',');) rows.back().push_back(std::stod(word));
  }
  return rows;
}

/// What each new vertex is made of: old vertices and weights.
std::vector<std::map<std::size_t, double>> read_origins(const std::string& folder, std::size_t vertices) {
  std::vector<std::map<std::size_t, double>> origins(vertices);
  for (const auto& row : read_table(folder + "/vertex_origins.csv", "new,old,weight")) {
    const auto inserted = origins.at(static_cast<std::size_t>(row[0])).emplace(row[1], row[2]);
    EXPECT_TRUE(inserted.second);
    EXPECT_GT(row[2], 0);
    EXPECT_LE(row[2], 1);
  }
  const auto map = read_table(folder + "/vertex_map.csv", "old,new");
  for (std::size_t old = 0; old < map.size(); ++old) {
    EXPECT_EQ(map[old][0], static_cast<double>(old));
    if (map[old][1] < 0) continue;
    auto& origin = origins.at(static_cast<std::size_t>(map[old][1]));
    if (origin.empty()) origin[old] = 1;
  }
  return origins;
}

double largest(const Displacements& u) {
  double size = 0;
  for (const Vec3& row : u) size = std::max(size, row.cwiseAbs().maxCoeff());
  return size;
}

double difference(const Displacements& a, const Displacements& b) {
  EXPECT_EQ(a.size(), b.size());
  double size = 0;
  for (std::size_t v = 0; v < std::min(a.size(), b.size()); ++v)
    size = std::max(size, (a[v] - b[v]).cwiseAbs().maxCoeff());
  return size;
}

TEST(SplitCommand, PartsTheOrganAndKeepsItsVolume) {
  const ModelFolder folder;
  folder.precompute();
  const auto summary = split(folder, {"--plane", middle_plane}, "cut");
  EXPECT_EQ(names_in(folder.name("cut")), (std::vector<std::string>{"C.h5", "cut.msh", "model.toml", "summary.json",
                                                                    "vertex_map.csv", "vertex_origins.csv"}));
  const TetMesh before = load_model(folder.model()).mesh(), after = load_model(folder.name("cut/model.toml")).mesh();
  EXPECT_EQ(summary.at("mode"), "split");
  EXPECT_EQ(face_connected_parts(after).count(), 2u);
  ASSERT_EQ(summary.at("parts").size(), 2u);
  EXPECT_EQ(summary.at("parts")[0].at("tets").get<std::size_t>() + summary.at("parts")[1].at("tets").get<std::size_t>(),
            after.tet_count());
  EXPECT_NE(summary.at("parts")[0].at("supported"), summary.at("parts")[1].at("supported"));
  const auto old_volumes = volumes(before), new_volumes = volumes(after);
  double old_total = 0, new_total = 0;
  for (const auto& [region, volume] : old_volumes) {
    EXPECT_NEAR(new_volumes.at(region), volume, 1e-3 * volume);
    old_total += volume;
    new_total += new_volumes.at(region);
  }
  EXPECT_NEAR(summary.at("volume_change").get<double>(), new_total - old_total, 1e-12 * old_total);
  EXPECT_EQ(after.tet_count(), before.tet_count() - summary.at("tets_removed").get<std::size_t>() +
                                   summary.at("tets_added").get<std::size_t>());
  EXPECT_EQ(after.vertex_count(), before.vertex_count() + summary.at("vertices_added").get<std::size_t>());
  EXPECT_EQ(summary.at("vertices_removed"), 0);
  // Each face that opened is two triangles more on the surface, next to what bisected outer faces add.
  EXPECT_GT(summary.at("faces_opened"), 10);
  EXPECT_GE(boundary_surface(after).triangles.size(),
            boundary_surface(before).triangles.size() + 2 * summary.at("faces_opened").get<std::size_t>());
  EXPECT_GE(summary.at("smallest_angle").at("after").get<double>(), quality(after).min_dihedral - 1e-9);
  EXPECT_GE(summary.at("smallest_angle").at("after"), 3);
  EXPECT_GT(summary.at("smallest_angle").at("before"), summary.at("smallest_angle").at("after"));
  EXPECT_GT(summary.at("rank"), 0);
  EXPECT_LT(summary.at("probe_residual"), 1e-8);
  // The lips lie in the plane.
  const Vec3 normal = Vec3(1, 0.07, 0.03).normalized();
  const auto lips = validate(after).coincident;
  EXPECT_GT(lips.size(), 5u);
  double farthest = 0;
  for (const VertexId v : lips)
    farthest = std::max(farthest, std::abs(normal.dot(after.position(v) - Vec3(0.0413, 0, 0))));
  EXPECT_NEAR(farthest, summary.at("flatness").get<double>(), 1e-12);
  EXPECT_LE(farthest, 0.25e-3);
}

TEST(SplitCommand, SaysWhereEveryVertexComesFrom) {
  const ModelFolder folder;
  folder.precompute({"--backend", "sparse"});
  const auto summary = split(
      folder, {"--plane", middle_plane, "--plane", "0,14mm,0,0.05,1,0.1", "--plane", "-3mm,0,2mm,0.1,0,1"}, "cut");
  const Model before = load_model(folder.model()), after = load_model(folder.name("cut/model.toml"));
  const auto origins = read_origins(folder.name("cut"), after.mesh().vertex_count());
  std::size_t mixed_of_many = 0, fixed_copies = 0;
  for (std::size_t v = 0; v < origins.size(); ++v) {
    ASSERT_FALSE(origins[v].empty()) << v;
    Vec3 place = Vec3::Zero();
    double sum = 0;
    bool fixed = true;
    for (const auto& [old, weight] : origins[v]) {
      place += weight * before.mesh().positions.at(old);
      sum += weight;
      fixed = fixed && before.is_fixed(VertexId(old));
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_LT((place - after.mesh().positions[v]).norm(), 1e-15);
    mixed_of_many += origins[v].size() > 2 ? 1 : 0;
    if (v < before.mesh().vertex_count()) {
      EXPECT_EQ(after.is_fixed(VertexId(v)), before.is_fixed(VertexId(v)));  // old ones stay as they are
    } else {
      EXPECT_EQ(after.is_fixed(VertexId(v)), fixed);
      fixed_copies += fixed ? 1 : 0;
    }
  }
  EXPECT_GT(mixed_of_many, 0u) << "no blade cut what another had made";
  EXPECT_GT(fixed_copies, 0u) << "no blade went through the supports";
  EXPECT_GT(summary.at("vertices_moved"), 0);
}

class SplitMethods : public testing::TestWithParam<std::tuple<double, const char*>> {};

TEST_P(SplitMethods, GiveTheSameAnswers) {
  const auto& [time_step, backend] = GetParam();
  const ModelFolder folder(time_step);
  folder.precompute({"--backend", backend});
  std::vector<std::string> blades = notch;  // so that the static model stays held
  if (time_step > 0) blades.insert(blades.end(), {"--plane", middle_plane});
  std::vector<Displacements> answers;
  double condition = 0;
  for (const std::string method : {"exact", "recompute"}) {
    std::vector<std::string> more = blades;
    more.insert(more.end(), {"--method", method});
    const auto summary = split(folder, more, method);
    EXPECT_GT(summary.at("faces_opened"), 5);
    const std::string model_file = folder.name(method + "/model.toml"), matrix = folder.name(method + "/C.h5");
    const Model model = load_model(model_file);
    const Compliance compliance = load_compliance(matrix, model);
    EXPECT_EQ(compliance.backend(), backend == std::string("dense") ? Backend::dense : Backend::sparse);
    std::vector<PointForce> forces{{VertexId(300), {0.1, -0.5, 0.2}}};
    for (const VertexId lip : validate(model.mesh()).coincident) forces.push_back({lip, {0.01, 0, -0.02}});
    EXPECT_GT(forces.size(), 5u);
    answers.push_back(compliance.solve(forces));
    condition = compliance.condition();
    const Outcome run =
        calot_run({"solve", model_file, matrix, "--force", "300,0.1,-0.5,0.2", "-o", folder.name("u.csv")});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.err.find("calot: warning"), std::string::npos) << run.err;
  }
  ASSERT_GT(largest(answers[1]), 0);
  EXPECT_LT(difference(answers[0], answers[1]),
            std::max(1e-9, 10 * std::numeric_limits<double>::epsilon() * condition) * largest(answers[1]));
}

INSTANTIATE_TEST_SUITE_P(All, SplitMethods,
                         testing::Combine(testing::Values(0.0, 0.02), testing::Values("dense", "sparse")),
                         [](const auto& chosen) {
                           return std::string(std::get<0>(chosen.param) > 0 ? "dynamic_" : "static_") +
                                  std::get<1>(chosen.param);
                         });

// Pushed everywhere in proportion to its mass, a part that nothing holds moves as one, by a h²/(1 + hα), and the rest
// doesn't feel it.
TEST(SplitCommand, APartThatIsCutOffMovesAsAFreeBody) {
  for (const std::string lumping : {"element", "uniform"}) {
    const ModelFolder folder;
    folder.edit_model("mass_lumping = \"element\"", "mass_lumping = \"" + lumping + "\"");
    folder.precompute();
    split(folder, {"--plane", middle_plane}, "cut");
    const Model before = load_model(folder.model()), model = load_model(folder.name("cut/model.toml"));
    const std::vector<double> old_masses = before.vertex_masses(), masses = model.vertex_masses();
    const double total = std::accumulate(masses.begin(), masses.end(), 0.0);
    // Shares are kept as such; a quarter of each tet's mass is, as far as the volume is.
    EXPECT_NEAR(total, std::accumulate(old_masses.begin(), old_masses.end(), 0.0),
                (lumping == "uniform" ? 1e-13 : 1e-4) * total);
    const Parts parts = face_connected_parts(model.mesh());
    ASSERT_EQ(parts.count(), 2u);
    const std::size_t loose =
        std::any_of(parts.vertices[0].begin(), parts.vertices[0].end(), [&](VertexId v) { return model.is_fixed(v); })
            ? 1
            : 0;
    const Vec3 acceleration(0.3, -2, 1);
    std::vector<PointForce> forces;
    for (const VertexId v : parts.vertices[loose]) forces.push_back({v, masses[v.index()] * acceleration});
    const Displacements u = load_compliance(folder.name("cut/C.h5"), model).solve(forces);
    const Vec3 expected = acceleration / model.dynamics().mass_factor();
    for (const VertexId v : parts.vertices[loose]) EXPECT_LT((u[v.index()] - expected).norm(), 1e-9 * expected.norm());
    for (const VertexId v : parts.vertices[1 - loose]) EXPECT_LT(u[v.index()].norm(), 1e-12 * expected.norm());
  }
}

TEST(SplitCommand, SplitsOneAfterAnotherAreSplitsAtOnce) {
  const ModelFolder folder;
  folder.precompute({"--backend", "sparse"});
  const std::string second = "0,14mm,0,0.05,1,0.1";
  const auto both = split(folder, {"--plane", middle_plane, "--plane", second}, "both");
  const auto one = split(folder, {"--plane", middle_plane}, "one");
  const Outcome run = calot_run({"cut", folder.name("one/model.toml"), folder.name("one/C.h5"), "--plane", second,
                                 "--mode", "split", "-o", folder.name("two")});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(load_model(folder.name("both/model.toml")).fingerprint(),
            load_model(folder.name("two/model.toml")).fingerprint());
  const auto two = nlohmann::json::parse(read_bytes(folder.name("two/summary.json")));
  EXPECT_EQ(both.at("parts").size(), two.at("parts").size());
  EXPECT_GT(both.at("parts").size(), 2u);
  EXPECT_EQ(both.at("faces_opened"), one.at("faces_opened").get<int>() + two.at("faces_opened").get<int>());
  EXPECT_EQ(both.at("rank"), one.at("rank").get<int>() + two.at("rank").get<int>());
}

TEST(SplitCommand, ACutMeshIsCutAnewAndRemovedFromAsAnyOther) {
  const ModelFolder folder;
  folder.precompute({"--backend", "sparse"});
  split(folder, {"--plane", middle_plane}, "cut");
  const Outcome again = calot_run({"precompute", folder.name("cut/model.toml"), "-o", folder.name("again.h5")});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find("at exactly the place of an earlier one"), std::string::npos) << again.out;
  EXPECT_NE(again.out.find("2 parts"), std::string::npos) << again.out;
  const Outcome removed = calot_run({"cut", folder.name("cut/model.toml"), folder.name("again.h5"), "--plane",
                                     duct_plane, "-o", folder.name("removed")});
  EXPECT_EQ(removed.code, 0) << removed.err;
  EXPECT_EQ(face_connected_parts(load_model(folder.name("removed/model.toml")).mesh()).count(), 3u);
  // A later cut into the same folder leaves nothing of the earlier one.
  const Outcome over =
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.name("cut")});
  EXPECT_EQ(over.code, 0) << over.err;
  EXPECT_EQ(names_in(folder.name("cut")),
            (std::vector<std::string>{"C.h5", "cut.msh", "model.toml", "summary.json", "vertex_map.csv"}));
}

TEST(SplitCommand, OpeningNothingIsAWarning) {
  const ModelFolder folder;
  folder.precompute({"--backend", "sparse"});
  const Outcome run = split_run(folder, {"--plane", "9m,0,0,1,0,0", "--plane", "8m,0,0,1,0,0"}, "cut");
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.err, "calot: warning: the cut opens nothing\n");
  EXPECT_NE(run.out.find("note: --plane 8m,0,0,1,0,0: nothing is cut"), std::string::npos) << run.out;
  const auto summary = nlohmann::json::parse(read_bytes(folder.name("cut/summary.json")));
  EXPECT_EQ(summary.at("faces_opened"), 0);
  EXPECT_TRUE(summary.at("smallest_angle").at("after").is_null());
  EXPECT_EQ(read_bytes(folder.name("cut/vertex_origins.csv")), "new,old,weight\n");
  EXPECT_EQ(load_model(folder.name("cut/model.toml")).fingerprint(), load_model(folder.model()).fingerprint());
}

TEST(SplitCommand, RefusesWhatDoesNotGoTogether) {
  const ModelFolder folder(0.0);
  const auto refused = [&](const std::vector<std::string>& more, int code, const std::vector<std::string>& words) {
    expect_refused(split_run(folder, more, "cut"), code, words);
    EXPECT_FALSE(std::filesystem::exists(folder.name("cut")));
  };
  refused({"--plane", middle_plane, "--method", "paper"}, 2, {"--method paper", "split", "exact or recompute"});
  refused({"--plane", middle_plane, "--clean"}, 2, {"--clean", "split"});
  refused({"--plane", middle_plane, "--region", "spleen"}, 2, {"spleen", "gallbladder"});
  refused({"--plane", "0,0,0,0,0,0"}, 2, {"length 0"});
  refused({}, 2, {"--plane"});
  folder.precompute();
  for (const std::string method : {"exact", "recompute"})
    refused({"--plane", middle_plane, "--method", method}, 1, {"part", "tets", "without support"});
}

TEST(SplitCommand, TheCutMeshGoesThroughEveryFormat) {
  const ModelFolder folder;
  folder.precompute({"--backend", "sparse"});
  split(folder, {"--plane", middle_plane}, "cut");
  const TetMesh mesh = read_mesh(folder.name("cut/cut.msh")).mesh;
  std::string from = folder.name("cut/cut.msh");
  for (const std::string format : {"msh22-binary", "msh41", "msh41-binary", "vtu-ascii", "vtu-base64", "vtu-appended",
                                   "vtu-zlib", "vtk-ascii", "vtk-binary", "msh22"}) {
    const std::string to = folder.name(format + "." + format.substr(0, 3));
    const Outcome run = calot_run({"convert", from, to, "--format", format});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.err.find("at exactly the place of an earlier one"), std::string::npos) << run.err;
    const TetMesh read = read_mesh(to).mesh;
    EXPECT_EQ(read.positions, mesh.positions) << format;
    EXPECT_EQ(read.tets, mesh.tets) << format;
    EXPECT_EQ(read.regions, mesh.regions) << format;
    EXPECT_EQ(read.region_names, mesh.region_names) << format;
    from = to;
  }
  for (const std::string ending : {"stl", "obj", "ply"}) {
    const std::string to = folder.name("organ." + ending);
    ASSERT_EQ(calot_run({"convert", folder.name("cut/cut.msh"), to}).code, 0);
    EXPECT_EQ(read_surface(to).triangles.size(), boundary_surface(mesh).triangles.size());
  }
}

}  // namespace
}  // namespace calot::test
