// The sparse backend through the whole chain: a small file that every command accepts.
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace calot::test {
namespace {

namespace fs = std::filesystem;

void run(const std::vector<std::string>& arguments) {
  const Outcome outcome = calot_run(arguments);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

/// The largest difference of two u.csv files over the largest entry of the second.
double relative_difference(const std::string& a, const std::string& b) {
  return std::stod(python(R"(
import numpy as np, sys
a, b = (np.loadtxt(p, delimiter=',', skiprows=1) for p in sys.argv[1:])
print(np.abs(a - b).max() / np.abs(b).max())
)",
                          {a, b}));
}

class SparseChain : public testing::Test {
 protected:
  void SetUp() override {
    folder.precompute({"--backend", "sparse"});
    run({"precompute", folder.model(), "-o", folder.name("dense.h5")});
  }
  ModelFolder folder;
};

TEST_F(SparseChain, TheFileHoldsAFactorAndIsSmall) {
  EXPECT_LT(5 * fs::file_size(folder.compliance()), fs::file_size(folder.name("dense.h5")));
  EXPECT_EQ(python(R"(
import h5py, sys
f = h5py.File(sys.argv[1], 'r')
assert 'factor' in f and 'compliance' not in f and f['node_ids'].shape == (389,)
assert f.attrs['kind'] == 'dynamic' and f['factor/values'].fletcher32
)",
                   {folder.compliance()}),
            "");
}

TEST_F(SparseChain, SolvesAsTheDenseOneDoes) {
  run({"solve", folder.model(), folder.compliance(), "--force", "300,0.1,0,1", "-o", folder.name("s.csv")});
  run({"solve", folder.model(), folder.name("dense.h5"), "--force", "300,0.1,0,1", "-o", folder.name("d.csv")});
  EXPECT_LT(relative_difference(folder.name("s.csv"), folder.name("d.csv")), 1e-10);
}

TEST_F(SparseChain, CutsAndStaysSparse) {
  // Close planes, so that vertices lose their last tet.
  const std::vector<std::string> planes{"--plane",        "40mm,0,0,1,0,0", "--plane",
                                        "43mm,0,0,1,0,0", "--plane",        "47mm,0,0,1,0,0"};
  const auto cut = [&](const std::string& compliance, const std::string& output, const std::string& method) {
    std::vector<std::string> arguments{"cut",  folder.model(), compliance,         "--method",
                                       method, "-o",           folder.name(output)};
    arguments.insert(arguments.end(), planes.begin(), planes.end());
    run(arguments);
    run({"solve", folder.name(output + "/model.toml"), folder.name(output + "/C.h5"), "--force", "200,0,1,0", "-o",
         folder.name(output + ".csv")});
  };
  cut(folder.compliance(), "sparse", "exact");
  cut(folder.compliance(), "again", "recompute");
  cut(folder.name("dense.h5"), "dense", "exact");
  EXPECT_LT(relative_difference(folder.name("sparse.csv"), folder.name("dense.csv")), 1e-9);
  EXPECT_LT(relative_difference(folder.name("again.csv"), folder.name("dense.csv")), 1e-9);
  for (const std::string output : {"sparse/C.h5", "again/C.h5"})
    EXPECT_EQ(python("import h5py, sys\nprint(sorted(h5py.File(sys.argv[1])))", {folder.name(output)}),
              "['factor', 'node_ids']\n");
}

TEST_F(SparseChain, BecomesAWholeMatrixWhereOneIsNeeded) {
  run({"convert", folder.compliance(), folder.name("s.comp"), "--model", folder.model()});
  run({"convert", folder.name("dense.h5"), folder.name("d.comp"), "--model", folder.model()});
  run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "--method", "paper", "-o",
       folder.name("cut")});
  EXPECT_EQ(python(R"(
import numpy as np, sys
a, b = (np.fromfile(p) for p in sys.argv[1:])
assert np.abs(a - b).max() < 1e-9 * np.abs(b).max()
)",
                   {folder.name("s.comp"), folder.name("d.comp")}),
            "");
}

TEST_F(SparseChain, RefusesADamagedFactor) {
  std::string bytes = read_bytes(folder.compliance());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  write_bytes(folder.compliance(), bytes);
  const std::vector<std::string> solve{"solve",   folder.model(), folder.compliance(), "--force",
                                       "3,0,0,1", "-o",           folder.name("u.csv")};
  expect_refused(calot_run(solve), 2, {"C.h5", "damaged"});
  for (const std::string spoil :
       {"f['factor/ordering'][0] = 4000000", "f['factor/ordering'][0] = f['factor/ordering'][1]",
        "f['factor/supernode_start'][1] = 0", "f['factor/rows'][0] = 0", "f['factor/row_start'][1] = -1",
        "v = f['factor/values'][:-1]; del f['factor/values']; f['factor/values'] = v",
        "f['factor/values'][0, 0] = float('nan')", "del f['factor/rows']"}) {
    folder.precompute({"--backend", "sparse"});
    python("import h5py, sys\nf = h5py.File(sys.argv[1], 'r+')\n" + spoil + "\nf.close()\n", {folder.compliance()});
    SCOPED_TRACE(spoil);
    expect_refused(calot_run(solve), 2, {"C.h5"});
  }
  EXPECT_FALSE(fs::exists(folder.name("u.csv")));
}

}  // namespace
}  // namespace calot::test
