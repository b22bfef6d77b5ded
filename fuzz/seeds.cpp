// Writes small valid files of every format into FOLDER, a folder for each fuzzer, to start from.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>

#include "calot/mesh/writers.h"
#include "calot/patient/import_options.h"
#include "fuzz/tiny_patient.h"
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

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_patient_seeds(const fs::path& folder) {
  write(folder / "patient_toml" / "whole", fuzz::tiny_patient_toml());
  std::ostringstream labels;
  write_import_options(labels, {});
  write(folder / "labels_toml" / "whole", labels.str());
  write(folder / "labels_toml" / "small",
        "[names]\n\"Gall Bladder\" = \"gallbladder\"\nspleen = \"ignore\"\n[numbers]\n5 = \"liver\"\n"
        "[resample]\nspacing = 0.5\n[clean]\nclosing = 1\n[draw]\noverlap = 1.0\n[fat]\nfill = true\n");
  const fs::path lines = folder / "lines.mrk.json";
  write_markups(lines, fuzz::tiny_patient().lines);
  write(folder / "centrelines" / "markups", std::string(1, '\0') + bytes_of(lines));
  fs::remove(lines);
  write(folder / "centrelines" / "table", "\1# by hand\nline cystic duct\n12.5 -3.0 41.0 1.4\n13.5, -3, 40, 1.5\n");
}

const char* const scene_toml = R"(title = "seed"
length_unit = "mm"
seconds = 2.0
gravity = [0, 0, -9.81]
cutting = "split"
[[block]]
region = "liver"
size = [40, 20, 10]
element_size = 10
fixed = ["x-"]
[[tube]]
points = [[0, 0, 50], [30, 0, 50], [60, 0, 60]]
radii = [2, 2, 6]
regions = ["cystic duct", "gallbladder"]
rings = 1
fixed = ["first", "last"]
[[region]]
region = "*"
body = "rigid"
young = 5e3
[[floor]]
normal = [0, 0, 2]
[[instrument]]
name = "a"
kind = "bowel grasper"
port = [100, 0, 150]
keyframes = [ { time = 0, tip = [0, 0, 20], roll = 90, opening = 30, grip = 1 }, { time = 1, fire = true } ]
[[instrument]]
name = "b"
kind = "hook"
poses = "p.csv"
[contact]
self_contact = false
[haptics]
instrument = "a"
)";

void write_scene_seeds(const fs::path& folder) {
  write(folder / "scene_toml" / "whole", scene_toml);
  write(folder / "poses" / "whole",
        "time,x,y,z,qw,qx,qy,qz,opening,grip,energy,fire\n0,1,2,3,1,0,0,0,30,2,0,0\n0.5,1,2,4,0,1,0,0,0,2,1,1\n");
}

void write_device_seeds(const fs::path& folder) {
  using namespace std::string_literals;
  write(folder / "controls_toml" / "whole",
        "[keys]\nclose_jaws = [\"space\", \"mouse left\"]\npause = \"F5\"\nhelp = []\n[mouse]\nspeed = 2\nwheel = 3.0\n"
        "[keyboard]\nspeed = 80\nroll = 90\n[gamepad]\nspeed = 100\ndead_zone = 0.2\nfulcrum = true\n");
  // Contents of a transform, a sensor with four values, and a stream that begins as a message does.
  const std::string one = "\x3f\x80\0\0"s, zero(4, '\0');
  write(folder / "igtl" / "transform",
        "\1"s + one + zero + zero + zero + one + zero + zero + zero + one + one + one + one);
  write(folder / "igtl" / "sensor", "\5\4\0"s + std::string(8 + 4 * 8, '\0'));
  write(folder / "igtl" / "stream", "\x20\0\1STATUS"s + std::string(56, '\0'));
}

const char* const nrrd_header = R"(NRRD0005
# a comment
type: unsigned short
dimension: 4
space: left-posterior-superior
space units: "mm" "mm" "mm"
sizes: 2 5 6 7
space directions: none (0.7,0,0) (0,0.7,0) (0,0,3)
kinds: list domain domain domain
endian: little
encoding: gzip
space origin: (-100,-120.5,30)
byte skip: 4
line skip: 1
data file: numbers.raw.gz
Segment0_ID:=Segment_1
Segment0_Name:=liver\nlobe
Segment0_LabelValue:=3
Segment0_Layer:=1
Segment0_Extent:=0 4 0 5 0 6
)";

/// A DICOM file with a nested sequence of undefined length and compressed pixels in two pieces; plain ones without.
std::string dicom(bool compressed) {
  using namespace std::string_literals;
  const std::string nested =
      "\x08\0\x40\x11SQ\0\0\xff\xff\xff\xff\xfe\xff\0\xe0\xff\xff\xff\xff\x08\0\x55\x11UI\x02\0"s +
      "1\0\xfe\xff\x0d\xe0"s + "\0\0\0\0\xfe\xff\xdd\xe0\0\0\0\0"s;
  const std::string pieces =
      "OB\0\0\xff\xff\xff\xff\xfe\xff\0\xe0\0\0\0\0\xfe\xff\0\xe0\x04\0\0\0abcd\xfe\xff\xdd\xe0\0\0\0\0"s;
  const std::string syntax = compressed ? "UI\x16\0"s + "1.2.840.10008.1.2.4.90" : "UI\x12\0"s + "1.2.840.10008.1.2\0"s;
  if (!compressed)
    return std::string(128, '\0') + "DICM\x02\0\x10\0"s + syntax + "\x28\0\x10\0\x02\0\0\0\x05\0"s +
           "\xe0\x7f\x10\0\x02\0\0\0ab"s;
  return std::string(128, '\0') + "DICM\x02\0\x10\0"s + syntax + nested + "\x20\0\x32\0DS\x06\0"s + "1\\2\\-3" +
         "\xe0\x7f\x10\0"s + pieces;
}

void write_all(const fs::path& folder) {
  write(folder / "nrrd" / "segments", nrrd_header);
  write(folder / "dicom" / "compressed", dicom(true));
  write(folder / "dicom" / "implicit", dicom(false));
  write_patient_seeds(folder);
  write_scene_seeds(folder);
  write_device_seeds(folder);
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
