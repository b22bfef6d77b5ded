// precompute → cut → solve → compare, and the files between them as other programs read them.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calot/fem/model_file.h"
#include "tests/app/program.h"

namespace calot::test {
namespace {

namespace fs = std::filesystem;

/// The rows of u.csv; fails the test unless its header is right.
std::vector<Vec3> read_csv(const std::string& path) {
  std::istringstream in(read_bytes(path));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "ux,uy,uz");
  std::vector<Vec3> u;
  while (std::getline(in, line)) {
    Vec3 row;
    EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &row[0], &row[1], &row[2]), 3) << line;
    u.push_back(row);
  }
  return u;
}

double largest(const std::vector<Vec3>& u) {
  double size = 0;
  for (const Vec3& row : u) size = std::max(size, row.cwiseAbs().maxCoeff());
  return size;
}

double difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double size = 0;
  for (std::size_t v = 0; v < std::min(a.size(), b.size()); ++v)
    size = std::max(size, (a[v] - b[v]).cwiseAbs().maxCoeff());
  return size;
}

std::vector<Vec3> solve(const std::string& model, const std::string& compliance, const std::string& force,
                        const std::string& output) {
  const Outcome run = calot_run({"solve", model, compliance, "--force", force, "-o", output});
  EXPECT_EQ(run.code, 0) << run.err;
  return read_csv(output);
}

TEST(Chain, PrecomputeSaysWhatItNeedsAndWritesAFileForEveryone) {
  const ModelFolder folder;
  const Outcome run = calot_run({"precompute", folder.model(), "-o", folder.compliance()});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_NE(run.out.find("389 vertices"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("memory needed: "), std::string::npos);
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"C.h5", "model.toml", "organ.msh"}));
  const std::string said = python(R"(
import h5py, numpy as np, sys, hashlib
f = h5py.File(sys.argv[1], 'r')
n = 389
C = f['compliance']
assert C.shape == (3*n, 3*n) and C.dtype == np.float64 and C.fletcher32 and C.chunks[1] == 3*n, C
A = f.attrs
assert A['units'] == 'm/N' and A['kind'] == 'dynamic' and A['time_step'] == 0.02, dict(A)
assert A['rayleigh_mass'] == 0.3 and A['rayleigh_stiffness'] == 0.002, dict(A)
assert A['mesh_sha256'] == hashlib.sha256(open(sys.argv[2], 'rb').read()).hexdigest()
assert A['calot_version'] == '0.1.0'
ids = f['node_ids']
assert ids.dtype == np.uint32 and (ids[:] == np.arange(n)).all()
C = C[:]
assert np.abs(C - C.T).max() <= 1e-15 * np.abs(C).max()
zero = (C == 0).all(axis=1).reshape(n, 3)
assert (zero.all(axis=1) == zero.any(axis=1)).all() and 0 < zero[:, 0].sum() < n
assert np.linalg.eigvalsh(C).min() > -1e-18
print('fine')
)",
                                  {folder.compliance(), folder.mesh()});
  EXPECT_EQ(said, "fine\n");
}

TEST(Chain, TheExactCutIsTheRecomputedOne) {
  for (const double time_step : {0.0, 0.02}) {
    const ModelFolder folder(time_step);
    folder.precompute();
    std::vector<std::string> cut{"cut", folder.model(), folder.compliance()};
    // A notch, so that the static model stays held.
    const std::vector<std::string> blade{"--blade", "20mm,15mm,40mm,1,0,0,0,1,0,60mm,20mm"};
    cut.insert(cut.end(), blade.begin(), blade.end());
    for (const std::string method : {"exact", "recompute"}) {
      std::vector<std::string> arguments = cut;
      arguments.insert(arguments.end(), {"--method", method, "-o", folder.name(method)});
      const Outcome run = calot_run(arguments);
      ASSERT_EQ(run.code, 0) << run.err;
      EXPECT_EQ(names_in(folder.name(method)),
                (std::vector<std::string>{"C.h5", "cut.msh", "model.toml", "summary.json", "vertex_map.csv"}));
    }
    const auto exact =
        solve(folder.name("exact/model.toml"), folder.name("exact/C.h5"), "300,0.1,-0.5,0.2", folder.name("e.csv"));
    const auto again = solve(folder.name("recompute/model.toml"), folder.name("recompute/C.h5"), "300,0.1,-0.5,0.2",
                             folder.name("r.csv"));
    ASSERT_GT(largest(again), 0);
    EXPECT_LT(difference(exact, again), 1e-9 * largest(again));
    const std::string said = python(R"(
import h5py, numpy as np, sys
a, b = (h5py.File(p, 'r')['compliance'][:] for p in sys.argv[1:])
assert a.shape == b.shape
scale = np.abs(b).max(axis=0)
free = scale > 0
assert (np.abs(a - b).max(axis=0)[free] / scale[free]).max() < 1e-8
assert (a[:, ~free] == 0).all()
)",
                                    {folder.name("exact/C.h5"), folder.name("recompute/C.h5")});
    EXPECT_EQ(said, "");
  }
}

TEST(Chain, ASummaryHasItsKeysAndThePartsAddUp) {
  const ModelFolder folder;
  folder.precompute();
  for (const std::string method : {"exact", "paper", "recompute"}) {
    const Outcome run = calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "--method",
                                   method, "-o", folder.name("out-" + method)});
    ASSERT_EQ(run.code, 0) << run.err;
    const auto summary = nlohmann::json::parse(read_bytes(folder.name("out-" + method + "/summary.json")));
    EXPECT_EQ(summary.at("method"), method);
    EXPECT_EQ(summary.at("mode"), "remove");
    const Model before = load_model(folder.model()), after = load_model(folder.name("out-" + method + "/model.toml"));
    EXPECT_EQ(summary.at("tets_removed"), before.mesh().tet_count() - after.mesh().tet_count());
    EXPECT_EQ(summary.at("vertices_removed"), before.mesh().vertex_count() - after.mesh().vertex_count());
    ASSERT_EQ(summary.at("parts").size(), 2u);
    std::size_t tets = 0, supported = 0;
    for (const auto& part : summary.at("parts")) {
      tets += part.at("tets").get<std::size_t>();
      supported += part.at("supported").get<bool>() ? 1 : 0;
      EXPECT_GT(part.at("vertices").get<std::size_t>(), 0u);
    }
    EXPECT_EQ(tets, after.mesh().tet_count());
    EXPECT_EQ(supported, 1u);  // the gallbladder is cut off
    for (const char* key : {"select", "usable", "fold", "total"})
      EXPECT_GE(summary.at("seconds").at(key).get<double>(), 0);
    EXPECT_EQ(summary.at("rank").get<int>() > 0, method == "exact");
    const double residual = summary.at("probe_residual");
    if (method == "paper")
      EXPECT_GT(residual, 1e-4);
    else
      EXPECT_LT(residual, 1e-8);
  }
}

TEST(Chain, TheVertexMapLeadsFromTheOldMeshToTheNew) {
  const ModelFolder folder;
  folder.precompute();
  ASSERT_EQ(
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.name("cut")}).code, 0);
  const Model before = load_model(folder.model()), after = load_model(folder.name("cut/model.toml"));
  std::istringstream in(read_bytes(folder.name("cut/vertex_map.csv")));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "old,new");
  long expected_old = 0, expected_new = 0;
  while (std::getline(in, line)) {
    long from = 0, to = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%ld,%ld", &from, &to), 2) << line;
    EXPECT_EQ(from, expected_old++);
    if (to < 0) {
      EXPECT_EQ(to, -1);
      continue;
    }
    EXPECT_EQ(to, expected_new++);  // survivors keep their order
    EXPECT_EQ(before.mesh().positions[static_cast<std::size_t>(from)],
              after.mesh().positions[static_cast<std::size_t>(to)]);
    EXPECT_EQ(before.fixed()[static_cast<std::size_t>(from)], after.fixed()[static_cast<std::size_t>(to)]);
  }
  EXPECT_EQ(expected_old, static_cast<long>(before.mesh().vertex_count()));
  EXPECT_EQ(expected_new, static_cast<long>(after.mesh().vertex_count()));
}

TEST(Chain, ThePaperZeroesWhatLiesBetweenPartsAndNothingElse) {
  const ModelFolder folder;
  folder.precompute();
  ASSERT_EQ(calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "--method", "paper", "-o",
                       folder.name("cut")})
                .code,
            0);
  const std::string said = python(R"(
import csv, h5py, numpy as np, sys
before = h5py.File(sys.argv[1] + '/C.h5', 'r')['compliance'][:]
f = h5py.File(sys.argv[1] + '/cut/C.h5', 'r')
after = f['compliance'][:]
assert f.attrs['approximate'] == 1
rows = list(csv.DictReader(open(sys.argv[1] + '/cut/vertex_map.csv')))
kept = [int(r['old']) for r in rows if int(r['new']) >= 0]
dofs = (3 * np.array(kept)[:, None] + np.arange(3)).ravel()
struck = before[np.ix_(dofs, dofs)]
same = after == struck
assert (same | (after == 0)).all()
assert 0 < (~same).sum() < same.size / 2
)",
                                  {folder.path()});
  EXPECT_EQ(said, "");
  // Solving with it gives the approximate answer, and says so.
  const Outcome run = calot_run({"solve", folder.name("cut/model.toml"), folder.name("cut/C.h5"), "--force", "5,0,1,0",
                                 "-o", folder.name("u.csv")});
  EXPECT_EQ(run.code, 0);
  EXPECT_NE(run.err.find("calot: warning: "), std::string::npos);
  // An exact update of it would not be exact.
  expect_refused(calot_run({"cut", folder.name("cut/model.toml"), folder.name("cut/C.h5"), "--plane", "40mm,0,0,1,0,0",
                            "-o", folder.name("cut2")}),
                 2, {"cut/C.h5", "approximate"});
}

TEST(Chain, CutsOneAfterAnotherAreCutsAtOnce) {
  const ModelFolder folder;
  folder.precompute();
  const std::string first = duct_plane, second = "42mm,0,0,1,-0.2,0.1";
  const auto cut = [&](const std::string& model, const std::string& compliance, std::vector<std::string> planes,
                       const std::string& output) {
    std::vector<std::string> arguments{"cut", model, compliance, "-o", folder.name(output)};
    for (const std::string& plane : planes) arguments.insert(arguments.end(), {"--plane", plane});
    const Outcome run = calot_run(arguments);
    ASSERT_EQ(run.code, 0) << run.err;
  };
  cut(folder.model(), folder.compliance(), {first, second}, "both");
  cut(folder.model(), folder.compliance(), {first}, "one");
  cut(folder.name("one/model.toml"), folder.name("one/C.h5"), {second}, "two");
  EXPECT_EQ(load_model(folder.name("both/model.toml")).fingerprint(),
            load_model(folder.name("two/model.toml")).fingerprint());
  const auto both = solve(folder.name("both/model.toml"), folder.name("both/C.h5"), "200,0,0,1", folder.name("b.csv"));
  const auto two = solve(folder.name("two/model.toml"), folder.name("two/C.h5"), "200,0,0,1", folder.name("t.csv"));
  EXPECT_LT(difference(both, two), 1e-9 * largest(both));
}

TEST(Chain, Float32HalvesTheFileAndTheAnswerStaysExact) {
  const ModelFolder folder;
  folder.precompute();
  const auto size = fs::file_size(folder.compliance());
  const auto exact = solve(folder.model(), folder.compliance(), "300,0,1,0", folder.name("u.csv"));
  folder.precompute({"--float32"});
  EXPECT_LT(fs::file_size(folder.compliance()), 0.55 * static_cast<double>(size));
  const auto refined = solve(folder.model(), folder.compliance(), "300,0,1,0", folder.name("u.csv"));
  EXPECT_LT(difference(exact, refined), 1e-6 * largest(exact));
  EXPECT_EQ(python("import h5py, sys\nprint(h5py.File(sys.argv[1])['compliance'].dtype)", {folder.compliance()}),
            "float32\n");
}

TEST(Chain, SolveAddsForcesAndWritesVtuToo) {
  const ModelFolder folder;
  folder.precompute();
  const auto a = solve(folder.model(), folder.compliance(), "300,0.1,0,0", folder.name("a.csv"));
  const auto b = solve(folder.model(), folder.compliance(), "200,0,0,-2", folder.name("b.csv"));
  const Outcome run = calot_run({"solve", folder.model(), folder.compliance(), "--force", "300,0.1,0,0", "--force",
                                 "200,0,0,-2", "-o", folder.name("both.csv")});
  ASSERT_EQ(run.code, 0) << run.err;
  auto sum = a;
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += b[v];
  const auto both = read_csv(folder.name("both.csv"));
  EXPECT_LT(difference(sum, both), 1e-12 * largest(both));
  ASSERT_EQ(
      calot_run({"solve", folder.model(), folder.compliance(), "--force", "300,0.1,0,0", "-o", folder.name("a.vtu")})
          .code,
      0);
  const std::string said = python(R"(
import meshio, numpy as np, sys
u = meshio.read(sys.argv[1]).point_data['displacement']
csv = np.loadtxt(sys.argv[2], delimiter=',', skiprows=1)
assert (u == csv).all()
)",
                                  {folder.name("a.vtu"), folder.name("a.csv")});
  EXPECT_EQ(said, "");
}

TEST(Chain, CompareShowsTheThreeMethodsBesideEachOther) {
  const ModelFolder folder;
  const Outcome run = calot_run(
      {"compare", folder.model(), "--plane", duct_plane, "--force", "200,0,-0.5,0.3", "-o", folder.name("cmp")});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(names_in(folder.name("cmp")),
            (std::vector<std::string>{"compare.csv", "compare.json", "compare.png", "compare.vtu"}));
  for (const char* word : {"recompute", "paper", "exact", "mean [mm]"})
    EXPECT_NE(run.out.find(word), std::string::npos) << run.out;
  const auto json = nlohmann::json::parse(read_bytes(folder.name("cmp/compare.json")));
  const auto& methods = json.at("methods");
  ASSERT_EQ(methods.size(), 3u);
  EXPECT_EQ(methods[0].at("method"), "recompute");
  EXPECT_EQ(methods[0].at("max_mm"), 0);
  EXPECT_EQ(methods[1].at("method"), "paper");
  EXPECT_GT(methods[1].at("max_mm").get<double>(), 1e-3 * json.at("peak_displacement_mm").get<double>());
  EXPECT_GE(methods[1].at("max_mm"), methods[1].at("mean_mm"));
  EXPECT_GT(methods[1].at("std_mm").get<double>(), 0);
  EXPECT_EQ(methods[2].at("method"), "exact");
  EXPECT_LT(methods[2].at("max_mm").get<double>(), 1e-9 * json.at("peak_displacement_mm").get<double>());
  const std::string csv = read_bytes(folder.name("cmp/compare.csv"));
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "method,seconds,max_mm,mean_mm,std_mm,max_percent_of_peak");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_EQ(read_bytes(folder.name("cmp/compare.png")).substr(1, 3), "PNG");
}

}  // namespace
}  // namespace calot::test
