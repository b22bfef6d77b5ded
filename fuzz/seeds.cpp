// Writes small valid files of every format into FOLDER, a folder for each fuzzer, to start from.
#include <filesystem>
#include <fstream>
#include <iostream>

#include "calot/mesh/writers.h"
#include "tests/support/meshes.h"

namespace {

using namespace calot;
namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

const char* const model_toml = R"(mesh = "m.msh"
length_unit = "mm"
region_names = { 1 = "wall", 2 = "duct" }
time_step = 0.02
rayleigh_mass = 0
rayleigh_stiffness = 1e-3
mass_lumping = "uniform"
total_mass = 0.01
[[material]]
region = "*"
young = 1.0e6
poisson = 0.45
density = 1000.0
[[fixed]]
box = { min = [0, 0.0, -1.0], max = [1.0, 1.0, 0.0] }
[[fixed]]
vertices = [0, 1]
[[fixed]]
region = "duct"
)";

void write_all(const fs::path& folder) {
  TetMesh mesh = test::two_tets();
  mesh.region_names = {{1, "one"}, {2, "number two"}};
  const std::vector<VertexArray> arrays{{"u", 1, {1, 2, 3, 4, 5}}};
  const Surface surface = boundary_surface(mesh);
  for (const bool binary : {false, true}) {
    const std::string kind = binary ? "binary" : "ascii";
    write(folder / "msh" / ("22" + kind), detail::format_msh22(mesh, arrays, binary));
    write(folder / "msh" / ("41" + kind), detail::format_msh41(mesh, arrays, binary));
    write(folder / "vtk" / kind, detail::format_vtk(mesh, arrays, binary));
    write(folder / "surface" / ("stl" + kind), std::string(1, '\0') + detail::format_stl(surface, binary, "seed"));
    write(folder / "surface" / ("ply" + kind), "\2" + detail::format_ply(surface, binary));
  }
  write(folder / "surface" / "obj", "\1" + detail::format_obj(surface));
  write(folder / "vtu" / "ascii", detail::format_vtu(mesh, arrays, detail::VtuFormat::ascii));
  write(folder / "vtu" / "base64", detail::format_vtu(mesh, arrays, detail::VtuFormat::base64));
  write(folder / "vtu" / "appended", detail::format_vtu(mesh, arrays, detail::VtuFormat::appended));
  write(folder / "vtu" / "zlib", detail::format_vtu(mesh, arrays, detail::VtuFormat::zlib));
  write(folder / "model_toml" / "whole", model_toml);
  write(folder / "compliance_h5" / "dense", std::string(64, '\0'));
  write(folder / "compliance_h5" / "sparse", std::string(18, '\0') + "\1" + std::string(64, '\0'));
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  write_all(words[1]);
  return 0;
}
