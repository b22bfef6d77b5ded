#include <gtest/gtest.h>

#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "tests/app/program.h"

namespace calot::test {
namespace {

Outcome convert(const std::string& from, const std::string& to, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"convert", from, to});
  return calot_run(more);
}

TEST(Convert, MeshesThroughAllFormatsBitForBit) {
  const ModelFolder folder;
  const TetMesh mesh = read_mesh(folder.mesh()).mesh;
  std::string from = folder.mesh();
  for (const std::string format : {"msh22-binary", "msh41", "msh41-binary", "vtu-ascii", "vtu-base64", "vtu-appended",
                                   "vtu-zlib", "vtk-ascii", "vtk-binary", "msh22"}) {
    const std::string to = folder.name(format + "." + format.substr(0, 3));
    const Outcome run = convert(from, to, {"--format", format});
    ASSERT_EQ(run.code, 0) << run.err;
    const TetMesh read = read_mesh(to).mesh;
    EXPECT_EQ(read.positions, mesh.positions) << format;
    EXPECT_EQ(read.tets, mesh.tets) << format;
    EXPECT_EQ(read.regions, mesh.regions) << format;
    EXPECT_EQ(read.region_names, mesh.region_names) << format;
    from = to;
  }
  for (const std::string ending : {"vtu", "vtk", "msh"})
    EXPECT_EQ(convert(folder.mesh(), folder.name("plain." + ending)).code, 0);
}

TEST(Convert, SurfacesOfMeshes) {
  const ModelFolder folder;
  const TetMesh mesh = read_mesh(folder.mesh()).mesh;
  for (const std::string ending : {"stl", "obj", "ply"}) {
    const std::string to = folder.name("organ." + ending), again = folder.name("again." + ending);
    ASSERT_EQ(convert(folder.mesh(), to).code, 0);
    EXPECT_EQ(read_surface(to).triangles.size(), boundary_surface(mesh).triangles.size());
    ASSERT_EQ(convert(folder.mesh(), to, {"--region", "cystic duct"}).code, 0);
    EXPECT_EQ(read_surface(to).triangles.size(), region_surface(mesh, 3).triangles.size());
    ASSERT_EQ(convert(to, again).code, 0);
    EXPECT_EQ(read_surface(again).triangles.size(), region_surface(mesh, 3).triangles.size());
  }
}

TEST(Convert, CompliancesToSofasFormatAndBack) {
  const ModelFolder folder;
  folder.precompute();
  ASSERT_EQ(convert(folder.compliance(), folder.name("organ.comp"), {"--model", folder.model()}).code, 0);
  EXPECT_EQ(python(R"(
import h5py, numpy as np, sys
C = h5py.File(sys.argv[1], 'r')['compliance'][:]
raw = np.fromfile(sys.argv[2])
assert raw.size == C.size, raw.size
assert (raw.reshape(C.shape) == C / 0.02).all()
)",
                   {folder.compliance(), folder.name("organ.comp")}),
            "");
  const Outcome back = convert(folder.name("organ.comp"), folder.name("back.h5"), {"--model", folder.model()});
  ASSERT_EQ(back.code, 0) << back.err;
  EXPECT_EQ(back.err, "");
  EXPECT_EQ(python(R"(
import h5py, numpy as np, sys
a, b = (h5py.File(p, 'r') for p in sys.argv[1:])
assert np.abs(a['compliance'][:] - b['compliance'][:]).max() <= 1e-15 * np.abs(a['compliance'][:]).max()
assert dict(a.attrs) == dict(b.attrs)
)",
                   {folder.compliance(), folder.name("back.h5")}),
            "");
  EXPECT_EQ(
      calot_run({"cut", folder.model(), folder.name("back.h5"), "--plane", duct_plane, "-o", folder.name("cut")}).code,
      0);
}

TEST(Convert, AForeignCompIsStoredAsApproximate) {
  const ModelFolder folder, soft;
  soft.edit_model("young = 8e+05", "young = 2e+05");
  soft.precompute();
  ASSERT_EQ(convert(soft.compliance(), folder.name("soft.comp"), {"--model", soft.model()}).code, 0);
  const Outcome run = convert(folder.name("soft.comp"), folder.compliance(), {"--model", folder.model()});
  EXPECT_EQ(run.code, 0);
  EXPECT_NE(run.err.find("not the inverse"), std::string::npos);
  expect_refused(
      calot_run({"cut", folder.model(), folder.compliance(), "--plane", duct_plane, "-o", folder.name("cut")}), 2,
      {"approximate"});
}

TEST(Convert, RefusesWhatCannotBe) {
  const ModelFolder folder;
  const auto before = names_in(folder.path());
  expect_refused(convert(folder.mesh(), folder.name("organ.docx")), 2, {".docx", ".msh"});
  expect_refused(convert(folder.name("gone.msh"), folder.name("a.vtu")), 2, {"gone.msh"});
  expect_refused(convert(folder.mesh(), folder.name("organ.comp")), 2, {"can't be made from .msh"});
  expect_refused(convert(folder.mesh(), folder.name("organ.vtu"), {"--format", "msh41"}), 2, {"--format", "msh41"});
  expect_refused(convert(folder.mesh(), folder.name("organ.vtu"), {"--region", "2"}), 2, {"--region"});
  expect_refused(convert(folder.mesh(), folder.name("organ.stl"), {"--region", "spleen"}), 2, {"spleen"});
  EXPECT_EQ(names_in(folder.path()), before);
  ASSERT_EQ(convert(folder.mesh(), folder.name("organ.stl")).code, 0);
  expect_refused(convert(folder.name("organ.stl"), folder.name("b.msh")), 2, {"no tetrahedra"});
  folder.precompute();
  expect_refused(convert(folder.compliance(), folder.name("a.comp")), 2, {"--model"});
  write_bytes(folder.name("short.comp"), std::string(800, '\0'));
  expect_refused(convert(folder.name("short.comp"), folder.name("a.h5"), {"--model", folder.model()}), 2,
                 {"short.comp", "800 bytes", "389 vertices"});
  EXPECT_FALSE(std::filesystem::exists(folder.name("a.h5")));
  const ModelFolder still(0.0);
  still.precompute();
  expect_refused(convert(still.compliance(), still.name("a.comp"), {"--model", still.model()}), 2,
                 {"a.comp", "static"});
}

}  // namespace
}  // namespace calot::test
