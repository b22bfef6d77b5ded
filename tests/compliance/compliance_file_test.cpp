// C.h5 and .comp as the library writes and reads them; tests/app tries them from outside, also with h5py.
#include "calot/compliance/compliance_file.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "calot/base/error.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace calot::test {
namespace {

double largest_difference(const FullCompliance& a, const FullCompliance& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  double difference = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    difference = std::max(difference, std::abs(a.values[i] - b.values[i]));
  return difference;
}

double largest(const FullCompliance& a) {
  double size = 0;
  for (const double value : a.values) size = std::max(size, std::abs(value));
  return size;
}

Model bar_model(double time_step) {
  return make_model(bar_mesh(4), time_step, [](const Vec3& p) { return p.x() == 0; });
}

TEST(ComplianceFile, KeepsEveryBit) {
  const TempFolder folder;
  for (const double time_step : {0.0, 0.01}) {
    const Model model = bar_model(time_step);
    const Compliance compliance = precompute(model);
    save_compliance(folder / "C.h5", compliance, model);
    const FullCompliance before = compliance.full(), after = load_full_compliance(folder / "C.h5", model);
    EXPECT_TRUE(before.values == after.values);
    const Compliance loaded = load_compliance(folder / "C.h5", model);
    EXPECT_LT(largest_difference(loaded.full(), before), 1e-15 * largest(before));
    EXPECT_LT(loaded.probe(), 1e-9);
    const ComplianceFileInfo info = read_compliance_info(folder / "C.h5", model);
    EXPECT_FALSE(info.float32);
    EXPECT_FALSE(info.approximate);
    EXPECT_EQ(info.calot_version, "0.1.0");
  }
}

TEST(ComplianceFile, Float32KeepsSevenDigitsAndSolvingRefinesThem) {
  const TempFolder folder;
  const Model model = bar_model(0.01);
  const Compliance compliance = precompute(model);
  save_compliance(folder / "C.h5", compliance, model, true);
  EXPECT_TRUE(read_compliance_info(folder / "C.h5", model).float32);
  const FullCompliance exact = compliance.full(), rounded = load_full_compliance(folder / "C.h5", model);
  for (std::size_t i = 0; i < exact.values.size(); ++i)
    EXPECT_EQ(rounded.values[i], static_cast<double>(static_cast<float>(exact.values[i])));
}

TEST(ComplianceFile, AFullMatrixMayBeApproximate) {
  const TempFolder folder;
  const Model model = bar_model(0.01);
  FullCompliance compliance = precompute(model).full();
  compliance.values[0] = 7;
  save_full_compliance(folder / "C.h5", compliance, model, false, nullptr, true);
  EXPECT_TRUE(read_compliance_info(folder / "C.h5", model).approximate);
  EXPECT_TRUE(load_full_compliance(folder / "C.h5", model).values == compliance.values);
  EXPECT_NE(message_of([&] { load_compliance(folder / "C.h5", model); }).find("approximate"), std::string::npos);
  EXPECT_THROW(save_full_compliance(folder / "D.h5", FullCompliance{3, std::vector<double>(81)}, model), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "D.h5"));
}

TEST(ComplianceFile, BelongsToItsModelOnly) {
  const TempFolder folder;
  const Model model = bar_model(0.01), still = bar_model(0), slower = bar_model(0.02);
  const Model stiffer = make_model(bar_mesh(4), 0.01, [](const Vec3& p) { return p.x() == 0; }, {2e6, 0.45, 1000});
  const Model looser = make_model(bar_mesh(4), 0.01, [](const Vec3& p) { return p.x() == 0 && p.y() == 0; });
  save_compliance(folder / "C.h5", precompute(model), model);
  for (const Model* other : {&still, &slower, &stiffer, &looser})
    EXPECT_THROW(load_compliance(folder / "C.h5", *other), InputError);
  EXPECT_NO_THROW(load_compliance(folder / "C.h5", bar_model(0.01)));
}

TEST(ComplianceFile, UnusedVerticesAreAbsentAndComeBackAsZeros) {
  const TempFolder folder;
  TetMesh mesh = bar_mesh(3);
  // Strays in front, in the middle and at the end.
  mesh.positions.insert(mesh.positions.begin(), Vec3(9, 9, 9));
  for (Tet& tet : mesh.tets)
    for (VertexId& v : tet) v = VertexId(v.index() + (v.index() >= 10 ? 2 : 1));
  mesh.positions.insert(mesh.positions.begin() + 11, Vec3(8, 8, 8));
  mesh.positions.emplace_back(7, 7, 7);
  const Model model = make_model(mesh, 0.01, [](const Vec3& p) { return p.x() == 0; });
  const Compliance compliance = precompute(model);
  save_compliance(folder / "C.h5", compliance, model);
  const FullCompliance before = compliance.full(), after = load_full_compliance(folder / "C.h5", model);
  EXPECT_TRUE(before.values == after.values);
  for (const std::size_t stray : {std::size_t{0}, std::size_t{11}, mesh.vertex_count() - 1})
    for (std::size_t c = 0; c < after.size(); ++c) EXPECT_EQ(after.row(3 * stray)[c], 0);
  EXPECT_LT(load_compliance(folder / "C.h5", model).probe(), 1e-9);
}

TEST(ComplianceFile, PendingCorrectionsMustBeFoldedFirst) {
  const TempFolder folder;
  Model model = bar_model(0.01);
  Compliance compliance = precompute(model);
  compliance.update(model.apply({.removed = {TetId(3)}, .vertices = {}, .tets = {}}));
  ASSERT_GT(compliance.pending_rank(), 0u);
  EXPECT_THROW(save_compliance(folder / "C.h5", compliance, model), InputError);
  compliance.fold();
  EXPECT_NO_THROW(save_compliance(folder / "C.h5", compliance, model));
  EXPECT_LT(load_compliance(folder / "C.h5", model).probe(), 1e-9);
}

TEST(ComplianceFile, ReportsProgressAndStops) {
  const TempFolder folder;
  const Model model = bar_model(0.01);
  const Compliance compliance = precompute(model);
  double last = -1;
  Progress watched([&](const ProgressState& state) { last = state.fraction; });
  save_compliance(folder / "C.h5", compliance, model, false, &watched);
  EXPECT_EQ(last, 1);
  Progress stopped;
  stopped.request_stop();
  EXPECT_THROW(save_compliance(folder / "D.h5", compliance, model, false, &stopped), Interrupted);
  EXPECT_FALSE(std::filesystem::exists(folder / "D.h5"));
  EXPECT_THROW(load_compliance(folder / "C.h5", model, &stopped), Interrupted);
}

// SOFA's layout: raw doubles, row after row, no header, C/h.
TEST(CompFile, ByteLayout) {
  const TempFolder folder;
  FullCompliance compliance{2, std::vector<double>(36)};
  for (std::size_t i = 0; i < 36; ++i) compliance.values[i] = 0.1 * static_cast<double>(i * i);
  write_comp(folder / "a.comp", compliance, 0.02);
  const std::string bytes = read_bytes(folder / "a.comp");
  ASSERT_EQ(bytes.size(), 36 * 8u);
  for (std::size_t i = 0; i < 36; ++i) {
    std::uint64_t bits = 0;
    for (std::size_t b = 0; b < 8; ++b) bits |= std::uint64_t{static_cast<unsigned char>(bytes[8 * i + b])} << (8 * b);
    EXPECT_EQ(std::bit_cast<double>(bits), compliance.values[i] / 0.02);
  }
  const FullCompliance read = read_comp(folder / "a.comp", 2, 0.02);
  EXPECT_LT(largest_difference(read, compliance), 1e-15 * largest(compliance));
}

TEST(CompFile, RefusesAStaticStepWrongSizesAndNan) {
  const TempFolder folder;
  FullCompliance compliance{1, std::vector<double>(9, 1.0)};
  for (const double step : {0.0, -1.0, std::nan("")})
    EXPECT_THROW(write_comp(folder / "a.comp", compliance, step), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.comp"));
  write_comp(folder / "a.comp", compliance, 0.1);
  EXPECT_THROW(read_comp(folder / "a.comp", 2, 0.1), InputError);
  EXPECT_THROW(read_comp(folder / "b.comp", 1, 0.1), InputError);
  compliance.values[4] = std::nan("");
  write_comp(folder / "c.comp", compliance, 0.1);
  EXPECT_NE(message_of([&] { read_comp(folder / "c.comp", 1, 0.1); }).find("entry 4"), std::string::npos);
}

}  // namespace
}  // namespace calot::test
