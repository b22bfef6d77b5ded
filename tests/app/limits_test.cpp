// A full disk, too little memory, and Ctrl-C: exit code 1, and nothing half-written.
#include <gtest/gtest.h>

#include "calot/mesh/mesh_file.h"
#include "tests/app/program.h"
#include "tests/support/meshes.h"

namespace calot::test {
namespace {

namespace fs = std::filesystem;

TEST(Limits, AFullDiskLeavesNothing) {
  const ModelFolder folder;
  folder.precompute();
  const auto before = names_in(folder.path());
  const std::string compliance = read_bytes(folder.compliance());
  for (const std::uint64_t limit : {std::uint64_t{1000}, std::uint64_t{5000000}}) {
    const RunOptions full{.largest_file = limit};
    expect_refused(calot_run({"precompute", folder.model(), "-o", folder.name("D.h5")}, full), 1,
                   {"D.h5", "can't be written"});
    // The old file stays as it was.
    expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}, full), 1,
                   {"C.h5", "can't be written"});
    EXPECT_TRUE(read_bytes(folder.compliance()) == compliance);
    for (const std::string method : {"exact", "paper"})
      expect_refused(calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "--method", method,
                                "-o", folder.name("cut/deep/down")},
                               full),
                     1, {"can't be written"});
    expect_refused(calot_run({"convert", folder.compliance(), folder.name("a.comp"), "--model", folder.model()}, full),
                   1, {"a.comp", "can't be written"});
    EXPECT_EQ(names_in(folder.path()), before);
  }
  const RunOptions full{.largest_file = 1000};
  expect_refused(
      calot_run({"solve", folder.model(), folder.compliance(), "--force", "1,0,0,1", "-o", folder.name("u.csv")}, full),
      1, {"u.csv"});
  expect_refused(calot_run({"convert", folder.mesh(), folder.name("a.vtu")}, full), 1, {"a.vtu"});
  expect_refused(
      calot_run({"compare", folder.model(), "--plane", duct_plane, "--force", "3,0,0,1", "-o", folder.name("cmp")},
                full),
      1, {"can't be written"});
  EXPECT_EQ(names_in(folder.path()), before);
}

TEST(Limits, StandardOutputMayBeFullToo) {
  const ModelFolder folder;
  const CommandResult result = run_command(std::string(CALOT_PROGRAM) + " convert " + folder.mesh() + " " +
                                           folder.name("a.vtu") + " > /dev/full");
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(result.output, "calot: error: standard output: can't be written; free some space\n");
}

TEST(Limits, MoreMemoryThanTheMachineHasIsSaidBeforehand) {
  TempFolder folder;
  write_mesh(folder / "box.msh", box_mesh(44, 44, 44, {0.1, 0.1, 0.1}), MeshFormat::msh22_binary);
  write_bytes(folder / "model.toml",
              "mesh = \"box.msh\"\ntime_step = 0.01\n[[material]]\nregion = \"*\"\nyoung = 1e5\npoisson = 0.4\n");
  // 91125 vertices: 598 GB.
  expect_refused(calot_run({"precompute", (folder / "model.toml").string(), "-o", (folder / "C.h5").string()}), 1,
                 {"GB", "memory"});
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"box.msh", "model.toml"}));
}

TEST(Limits, CtrlCWhileComputing) {
  const ModelFolder folder(0.02, 2);
  const auto before = names_in(folder.path());
  const RunOptions at_once{
      .interrupt_when = [](const std::string& out) { return out.find("memory needed") != std::string::npos; }};
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}, at_once), 1,
                 {"stopped on request"});
  EXPECT_EQ(names_in(folder.path()), before);
}

TEST(Limits, CtrlCWhileWriting) {
  const ModelFolder folder(0.02, 2);
  const auto before = names_in(folder.path());
  const RunOptions when_writing{
      .interrupt_when = [&](const std::string&) { return names_in(folder.path()) != before; }};
  expect_refused(calot_run({"precompute", folder.model(), "-o", folder.compliance()}, when_writing), 1,
                 {"stopped on request"});
  EXPECT_EQ(names_in(folder.path()), before);
  folder.precompute();
  const auto computed = names_in(folder.path());
  const RunOptions when_cut{.interrupt_when = [&](const std::string&) { return names_in(folder.path()) != computed; }};
  expect_refused(
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.name("cut")},
                when_cut),
      1, {"stopped on request"});
  EXPECT_EQ(names_in(folder.path()), computed);
}

}  // namespace
}  // namespace calot::test
