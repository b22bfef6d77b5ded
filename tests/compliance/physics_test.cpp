// Against what is known from outside: beam theory, and another finite-element program.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/support/accuracy.h"
#include "tests/support/files.h"

namespace calot {
namespace {

constexpr double length = 0.1, side = 0.02, young = 1e6;

// Mean deflection of the end face of a cantilever of `cells` × 2m × 2m cubes under a unit end load spread over it.
double end_deflection(int cells, int across) {
  TetMesh mesh = test::box_mesh(cells, across, across, {length, side, side}, test::CubeSplit::five);
  const Model model =
      test::make_model(std::move(mesh), 0.0, [](const Vec3& p) { return p.x() < 1e-9; }, {young, 0.0, 1000});
  std::vector<VertexId> end;
  for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v)
    if (model.mesh().positions[v].x() > length - 1e-9) end.push_back(VertexId(v));
  std::vector<PointForce> forces;
  for (const VertexId v : end) forces.push_back({v, Vec3(0, -0.01 / static_cast<double>(end.size()), 0)});
  const Displacements u = precompute(model, {Backend::sparse}).solve(forces);
  double sum = 0;
  for (const VertexId v : end) sum += u[v.index()].y();
  return -sum / static_cast<double>(end.size());
}

// Timoshenko: F L³/(3 E I) + F L/(κ G A), κ = 5/6, G = E/2 for ν = 0. Linear tets are too stiff and converge from
// below.
TEST(Cantilever, ConvergesToBeamTheory) {
  const double inertia = std::pow(side, 4) / 12, area = side * side;
  const double theory =
      0.01 * std::pow(length, 3) / (3 * young * inertia) + 0.01 * length / (5.0 / 6 * young / 2 * area);
  const double coarse = end_deflection(20, 4), fine = end_deflection(40, 8), finest = end_deflection(80, 16);
  EXPECT_LT(coarse, fine);
  EXPECT_LT(fine, finest);
  EXPECT_LT(finest, theory);
  EXPECT_GT(finest, 0.98 * theory);
  // Second order: halving the cells takes the error down about four times.
  EXPECT_NEAR((theory - coarse) / (theory - fine), 4, 1.2);
}

// CalculiX's four-node tet C3D4 is the same element: the same displacements to the digits it prints.
TEST(CalculiX, GivesTheSameDisplacements) {
  const Model model = test::biliary_model(0.0);
  const test::TempFolder folder;
  std::ofstream input(folder / "organ.inp");
  input.precision(12);  // It reads twenty characters a number.
  input << "*NODE, NSET=ALL\n";
  for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v)
    input << v + 1 << ", " << model.mesh().positions[v].x() << ", " << model.mesh().positions[v].y() << ", "
          << model.mesh().positions[v].z() << "\n";
  for (const auto& [region, material] : model.materials()) {
    input << "*ELEMENT, TYPE=C3D4, ELSET=R" << region << "\n";
    for (std::size_t t = 0; t < model.mesh().tet_count(); ++t)
      if (model.mesh().regions[t] == region) {
        input << t + 1;
        for (const VertexId v : model.mesh().tets[t]) input << ", " << v.value + 1;
        input << "\n";
      }
    input << "*MATERIAL, NAME=M" << region << "\n*ELASTIC\n"
          << material.young << ", " << material.poisson << "\n*SOLID SECTION, ELSET=R" << region << ", MATERIAL=M"
          << region << "\n";
  }
  input << "*BOUNDARY\n";
  for (std::size_t v = 0; v < model.mesh().vertex_count(); ++v)
    if (model.is_fixed(VertexId(v))) input << v + 1 << ", 1, 3\n";
  input << "*STEP\n*STATIC\n*CLOAD\n5, 1, 0.01\n5, 2, -0.02\n40, 3, 0.03\n*NODE PRINT, NSET=ALL\nU\n*END STEP\n";
  input.close();
  const test::CommandResult run = test::run_command("cd '" + folder.path().string() + "' && ccx organ");
  ASSERT_EQ(run.status, 0) << "CalculiX (package calculix-ccx) is needed: " << run.output;

  const Displacements u = precompute(model).solve({{VertexId(4), {0.01, -0.02, 0}}, {VertexId(39), {0, 0, 0.03}}});
  double largest = 0;
  for (const Vec3& d : u) largest = std::max(largest, d.norm());
  std::ifstream output(folder / "organ.dat");
  std::size_t read = 0;
  double worst = 0;
  for (std::string line; std::getline(output, line);) {
    std::istringstream in(line);
    std::size_t vertex = 0;
    Vec3 d;
    if (!(in >> vertex >> d.x() >> d.y() >> d.z()) || vertex < 1 || vertex > u.size()) continue;
    worst = std::max(worst, (d - u[vertex - 1]).norm());
    ++read;
  }
  EXPECT_EQ(read, u.size());
  EXPECT_LT(worst, 1e-5 * largest);
}

}  // namespace
}  // namespace calot
