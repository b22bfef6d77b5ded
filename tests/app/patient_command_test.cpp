// calot phantom → calot patient → calot patient --check, and what a user gets wrong on the way.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "calot/fem/model_file.h"
#include "tests/app/program.h"

namespace calot::test {
namespace {

namespace fs = std::filesystem;

/// A folder with the inputs of a small phantom.
class PhantomFolder : public TempFolder {
 public:
  PhantomFolder() {
    const Outcome run = calot_run({"phantom", "-o", name("in"), "--seed", "3", "--voxel", "1.0"});
    EXPECT_EQ(run.code, 0) << run.err;
  }
  [[nodiscard]] std::string name(const std::string& file) const { return (path() / file).string(); }
  [[nodiscard]] std::string ct() const { return name("in/ct.nii.gz"); }
  [[nodiscard]] std::string labels() const { return name("in/labels.nii.gz"); }
  /// Runs Python with the labels' image `i` and data `d`; saves them as bad.nii.gz. Returns its name.
  [[nodiscard]] std::string damaged(const std::string& how) const {
    python(
        "import sys, numpy as np, nibabel as nib\ni = nib.load(sys.argv[1])\nd = np.asarray(i.dataobj).copy()\na = "
        "i.affine.copy()\nh = i.header.copy()\n" +
            how + "\nnib.Nifti1Image(d, a, h).to_filename(sys.argv[2])",
        {labels(), name("bad.nii.gz")});
    return name("bad.nii.gz");
  }
};

std::vector<std::string> all_files(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) names.push_back(fs::relative(entry.path(), folder).string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(PatientCommand, GoesFromAPhantomToACheckedFolder) {
  const PhantomFolder folder;
  const Outcome made = calot_run(
      {"patient", folder.ct(), folder.labels(), "-o", folder.name("anna"), "--tets", "14000", "--compliance"});
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* part : {"is the gallbladder", "mesh: ", "closed and manifold", "held: ", "wrote "})
    EXPECT_NE(made.out.find(part), std::string::npos) << part << " isn't in\n" << made.out;
  const std::vector<std::string> files = all_files(folder / "anna");
  for (const char* file : {"C.h5", "labels.nii.gz", "mesh.msh", "mesh.vtu", "model.toml", "patient.toml", "preview.png",
                           "provenance.json", "quality.json", "surfaces/liver.ply", "surfaces/cystic_duct.ply"})
    EXPECT_NE(std::find(files.begin(), files.end(), file), files.end()) << file;
  const Outcome check = calot_run({"patient", "--check", folder.name("anna")});
  EXPECT_EQ(check.code, 0) << check.out << check.err;
  EXPECT_NE(check.out.find("sound"), std::string::npos);
  const Model model = load_model(folder / "anna" / "model.toml");
  EXPECT_LE(model.mesh().tet_count(), 14000u);
  const auto provenance = nlohmann::json::parse(read_bytes(folder / "anna" / "provenance.json"));
  EXPECT_EQ(provenance.at("inputs").size(), 2u);

  // The same on one thread: the same bytes.
  setenv("CALOT_THREADS", "1", 1);
  const Outcome again = calot_run({"patient", folder.ct(), folder.labels(), "-o", folder.name("again"), "--name",
                                   "anna", "--tets", "14000", "--compliance"});
  unsetenv("CALOT_THREADS");
  ASSERT_EQ(again.code, 0) << again.err;
  ASSERT_EQ(all_files(folder / "again"), files);
  for (const std::string& file : files)
    EXPECT_TRUE(read_bytes(folder / "anna" / file) == read_bytes(folder / "again" / file)) << file;

  // Made anew in its place, without the compliance: the old one, of another mesh, goes.
  const Outcome anew =
      calot_run({"patient", folder.ct(), folder.labels(), "-o", folder.name("again"), "--tets", "15000"});
  ASSERT_EQ(anew.code, 0) << anew.err;
  EXPECT_FALSE(fs::exists(folder / "again" / "C.h5"));
  EXPECT_TRUE(read_bytes(folder / "again" / "patient.toml.old") == read_bytes(folder / "anna" / "patient.toml"));

  // Damaged, and edited by hand with mistakes.
  write_bytes(folder / "anna" / "C.h5", std::string(10, 'x'));
  std::string toml = read_bytes(folder / "anna" / "patient.toml");
  toml.replace(toml.find("young = 5400.0"), 14, "young = 0.0000");
  write_bytes(folder / "anna" / "patient.toml", toml);
  fs::remove(folder / "anna" / "surfaces" / "liver.ply");
  const Outcome broken = calot_run({"patient", "--check", folder.name("anna")});
  EXPECT_EQ(broken.code, 2);
  EXPECT_NE(broken.out.find("young"), std::string::npos) << broken.out;
  EXPECT_NE(broken.out.find("liver.ply"), std::string::npos) << broken.out;
  EXPECT_NE(broken.out.find("C.h5"), std::string::npos) << broken.out;
  EXPECT_NE(broken.err.find("wrong, see above"), std::string::npos) << broken.err;
}

TEST(PatientCommand, RefusesBadLabelsAndLeavesNothing) {
  const PhantomFolder folder;
  const auto refused = [&](const std::string& labels, const std::vector<std::string>& parts) {
    expect_refused(calot_run({"patient", folder.ct(), labels, "-o", folder.name("out")}), 2, parts);
    EXPECT_FALSE(fs::exists(folder / "out"));
  };
  refused(folder.damaged("h.extensions.clear()"), {"numbers without names", "1: ", "[numbers]", "--table"});
  refused(folder.damaged("d[d == 2] = 0"), {"gallbladder"});
  refused(folder.damaged("d = d[:, :, ::2]; a[:, 2] *= 2"), {"bad.nii.gz", "grid", "--resample-labels"});
  refused(folder.damaged("d = np.roll(d, np.argwhere(d == 2)[:, 2].min() * -1 - 3, 2)"),
          {"gallbladder", "cut by the volume's"});
  refused(folder.damaged("d = d[..., None].repeat(2, 3)"), {"bad.nii.gz", "4 dimensions"});
  refused(folder.damaged("a[0, 1] = 0.4"), {"bad.nii.gz", "shear"});
  refused(folder.damaged("d = d.astype(np.float32) + 0.5; h.set_data_dtype(np.float32)"), {"bad.nii.gz", "no label"});
  refused(folder.name("in/truth.json"), {"truth.json"});
  refused(folder.ct(), {"ct.nii.gz"});  // the CT instead of labels
  refused(folder.name("missing.nii.gz"), {"missing.nii.gz"});
}

TEST(PatientCommand, RefusesBadCentrelinesAndTables) {
  const PhantomFolder folder;
  const auto refused = [&](const std::string& option, const std::string& text, const std::vector<std::string>& parts) {
    const std::string file = folder.name(option == "--table" ? "labels.toml" : "lines.txt");
    write_bytes(file, text);
    expect_refused(calot_run({"patient", folder.ct(), folder.labels(), option, file, "-o", folder.name("out")}), 2,
                   parts);
    EXPECT_FALSE(fs::exists(folder / "out"));
  };
  refused("--ducts", "line cystic duct\n0 0 0 1.4\n5 oops 0 1.4\n", {"lines.txt:3"});
  refused("--ducts", "line cystic duct\n0 0 0 1.4\n", {"lines.txt", "two points"});
  refused("--ducts", "line spleen\n0 0 0 1.4\n5 0 0 1.4\n", {"spleen"});
  refused("--ducts", "line cystic duct\n0 0 0 1.4\n0 40 0 1.4\n0 80 0 1.4\n0 120 0 1.4\n0 170 0 1.4\n",
          {"cystic duct", "volume"});
  refused("--table", "[names]\n\"x\" = \"spleen\"\n", {"labels.toml:2", "spleen"});
  refused("--table", "[fat]\nfat_low = \"much\"\n", {"labels.toml:2", "fat_low"});
}

TEST(PatientCommand, RefusesAWrongCall) {
  const TempFolder folder;
  expect_refused(calot_run({"patient"}), 2, {"CT, LABELS and -o DIR", "--help"});
  expect_refused(calot_run({"patient", "a.nii.gz", "b.nii.gz"}), 2, {"-o DIR"});
  expect_refused(calot_run({"patient", "a.nii.gz", "b.nii.gz", "-o", (folder / "x").string()}), 2, {"a.nii.gz"});
  expect_refused(calot_run({"patient", "--check", (folder / "nobody").string()}), 2, {"nobody"});
  expect_refused(calot_run({"patient", "--check", folder.path().string()}), 2, {});
  write_bytes(folder / "file", "x");
  expect_refused(calot_run({"patient", "a.nii.gz", "b.nii.gz", "-o", (folder / "file").string()}), 2, {"not a folder"});
  expect_refused(calot_run({"phantom", "-o", (folder / "p").string(), "--variant", "odd"}), 2, {"odd", "inflamed"});
}

TEST(PatientCommand, ReplacesNothingOfTheUsers) {
  const PhantomFolder folder;
  const std::string labels = read_bytes(folder.labels());
  expect_refused(calot_run({"patient", folder.ct(), folder.labels(), "-o", folder.name("in")}), 2,
                 {"holds other files", "patient.toml"});
  EXPECT_TRUE(read_bytes(folder.labels()) == labels);
  write_bytes(folder / "notes.txt", "mine");
  expect_refused(calot_run({"phantom", "-o", folder.path().string()}), 2, {"holds other files", "truth.json"});
  write_bytes(folder / "labels.toml", "# mine\n");
  expect_refused(calot_run({"patient", "--write-table", folder.name("labels.toml")}), 2, {"exists already"});
  EXPECT_EQ(read_bytes(folder / "labels.toml"), "# mine\n");
  expect_refused(calot_run({"patient", "--check", folder.name("in"), folder.ct()}), 2, {"--check"});
}

TEST(PatientCommand, RefusesFewerTetsThanThinTubesNeed) {
  const PhantomFolder folder;
  expect_refused(calot_run({"patient", folder.ct(), folder.labels(), "-o", folder.name("out"), "--tets", "4000"}), 1,
                 {"volume", "more tets"});
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(PatientCommand, WritesATableThatReadsBack) {
  const PhantomFolder folder;
  const Outcome table = calot_run({"patient", "--write-table", folder.name("labels.toml")});
  ASSERT_EQ(table.code, 0) << table.err;
  const Outcome names = calot_run({"patient", "--names"});
  EXPECT_NE(names.out.find("gallbladder"), std::string::npos);
  // Read before anything else is, so a mistake in another input shows that the table was fine.
  expect_refused(calot_run({"patient", folder.name("none.nii.gz"), folder.labels(), "--table",
                            folder.name("labels.toml"), "-o", folder.name("out")}),
                 2, {"none.nii.gz"});
}

}  // namespace
}  // namespace calot::test
