// Compliance files that must be refused, each with its reason.
#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace calot::test {
namespace {

class BadCompliance : public testing::Test {
 protected:
  void SetUp() override { folder.precompute(); }
  /// cut and solve refuse the compliance and write nothing.
  void refused(std::vector<std::string> words) {
    words.push_back("C.h5");
    const auto before = names_in(folder.path());
    expect_refused(
        calot_run({"solve", folder.model(), folder.compliance(), "--force", "9,0,0,1", "-o", folder.name("u.csv")}), 2,
        words);
    for (const std::string method : {"exact", "paper"})
      expect_refused(calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "--method", method,
                                "-o", folder.name("cut")}),
                     2, words);
    EXPECT_EQ(names_in(folder.path()), before);
  }
  void change(const std::string& statement) {
    python("import h5py, sys, numpy as np\nf = h5py.File(sys.argv[1], 'r+')\n" + statement + "\nf.close()\n",
           {folder.compliance()});
  }
  ModelFolder folder;
};

TEST_F(BadCompliance, MissingEmptyGarbageOrTruncated) {
  const std::string bytes = read_bytes(folder.compliance());
  std::filesystem::remove(folder.compliance());
  refused({"no such file"});
  write_bytes(folder.compliance(), "");
  refused({"not an HDF5 file"});
  write_bytes(folder.compliance(), std::string(5000, 'x'));
  refused({"not an HDF5 file"});
  write_bytes(folder.compliance(), bytes.substr(0, bytes.size() / 2));
  refused({"truncated"});
  write_bytes(folder.compliance(), bytes.substr(0, bytes.size() - 1));
  refused({"truncated"});
}

TEST_F(BadCompliance, AFlippedBitFailsItsChecksum) {
  std::string bytes = read_bytes(folder.compliance());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_bytes(folder.compliance(), bytes);
  refused({"damaged", "hecksum"});
}

TEST_F(BadCompliance, OfAnotherMesh) {
  const ModelFolder other(0.02, 2);
  other.precompute();
  std::filesystem::copy_file(other.compliance(), folder.compliance(),
                             std::filesystem::copy_options::overwrite_existing);
  refused({"another mesh"});
}

TEST_F(BadCompliance, OfAnotherModelOfTheSameMesh) {
  folder.edit_model("young = 8e+05", "young = 9e+05");
  refused({"other materials"});
  folder.edit_model("time_step = 0.02", "time_step = 0.04");
  refused({"time_step = 0.02", "0.04"});
  folder.edit_model("time_step = 0.04", "time_step = 0");
  refused({"dynamic", "static"});
}

TEST_F(BadCompliance, OfANewerVersion) {
  change("f.attrs['calot_version'] = '0.2.7'");
  refused({"0.2.7", "newer"});
  change("f.attrs['calot_version'] = '10.0.0'");
  refused({"10.0.0", "newer"});
  change("f.attrs['calot_version'] = 'soon'");
  refused({"calot_version"});
  change("del f.attrs['calot_version']");
  refused({"calot_version"});
}

TEST_F(BadCompliance, OfTheWrongShape) {
  change("C = f['compliance'][:]; del f['compliance']; f['compliance'] = C[:-3, :-3]");
  refused({"1164"});
  change("del f['compliance']; f['compliance'] = np.zeros(5)");
  refused({"not a matrix"});
  change("del f['compliance']");
  refused({"no /compliance"});
}

TEST_F(BadCompliance, WithOtherNodes) {
  change("f['node_ids'][0] = 7");
  refused({"node_ids"});
  change("del f['node_ids']");
  refused({"no /node_ids"});
}

TEST_F(BadCompliance, WithEntriesThatAreNotNumbers) {
  change("f['compliance'][100, 3] = np.nan");
  refused({"not finite"});
}

TEST_F(BadCompliance, ButOneWrittenElsewhereIsWelcome) {
  // Contiguous, big endian, without our fingerprint: mesh, step and damping still say that it belongs.
  change(
      "C = f['compliance'][:]; del f['compliance']; f['compliance'] = C.astype('>f8'); del f.attrs['model_sha256']; "
      "del f.attrs['approximate']");
  const Outcome run =
      calot_run({"solve", folder.model(), folder.compliance(), "--force", "9,0,0,1", "-o", folder.name("u.csv")});
  EXPECT_EQ(run.code, 0) << run.err;
}

}  // namespace
}  // namespace calot::test
