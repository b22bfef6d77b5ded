#include "calot/patient/label_mesh_files.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <set>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/mesh/mesh_file.h"
#include "calot/patient/quality_json.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

/// Lower case, with spaces for everything that isn't a letter or a digit: "Common_Bile-Duct" is "common bile duct".
std::string plain(const std::string& name) {
  std::string text;
  for (const char c : name)
    text += std::isalnum(static_cast<unsigned char>(c)) ? static_cast<char>(std::tolower(static_cast<unsigned char>(c)))
                                                        : ' ';
  return text;
}

std::vector<VertexId> vertices_of(const TetMesh& mesh, std::int32_t region) {
  std::set<VertexId> vertices;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    if (mesh.regions[t] == region) vertices.insert(mesh.tets[t].begin(), mesh.tets[t].end());
  return {vertices.begin(), vertices.end()};
}

/// Boxes around the vertices of a tube within a diameter of its two extremes along its main axis.
Support tube_ends(const LabelMesh& meshed, const MeshedRegion& region) {
  const std::vector<VertexId> vertices = vertices_of(meshed.mesh, region.label);
  Vec3 mean = Vec3::Zero();
  for (const VertexId v : vertices) mean += meshed.mesh.position(v) / static_cast<double>(vertices.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const VertexId v : vertices)
    spread += (meshed.mesh.position(v) - mean) * (meshed.mesh.position(v) - mean).transpose();
  Vec3 axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
  if (axis[2] < 0) axis = -axis;
  double low = 0, high = 0;
  for (const VertexId v : vertices) {
    low = std::min(low, axis.dot(meshed.mesh.position(v) - mean));
    high = std::max(high, axis.dot(meshed.mesh.position(v) - mean));
  }
  const double reach = std::max(0.04 * (high - low), 1.2 * region.quality.mean_edge);
  Support support;
  support.reason = "the two ends of the " + region.name + ", which the liver and the duodenum hold";
  for (const bool upper : {false, true}) {
    Eigen::AlignedBox3d box;
    for (const VertexId v : vertices) {
      const double along = axis.dot(meshed.mesh.position(v) - mean);
      if (upper ? along >= high - reach : along <= low + reach) box.extend(meshed.mesh.position(v));
    }
    support.boxes.emplace_back(Vec3(box.min().array() - 0.1 * mm), Vec3(box.max().array() + 0.1 * mm));
    support.box_reasons.push_back(upper ? "upper end of the " + region.name : "lower end of the " + region.name);
  }
  return support;
}

std::set<VertexId> outer_vertices(const TetMesh& mesh) {
  const Surface surface = boundary_surface(mesh);
  return {surface.vertex_of_mesh.begin(), surface.vertex_of_mesh.end()};
}

/// Outer vertices of the largest region that are far from the others; at least a tenth of them.
Support far_side(const LabelMesh& meshed, const MeshedRegion& largest) {
  const TetMesh& mesh = meshed.mesh;
  const std::set<VertexId> outer = outer_vertices(mesh);
  std::vector<VertexId> others;
  for (const MeshedRegion& region : meshed.regions)
    if (region.label != largest.label)
      for (const VertexId v : vertices_of(mesh, region.label)) others.push_back(v);
  std::vector<std::pair<double, VertexId>> reach;
  for (const VertexId v : vertices_of(mesh, largest.label)) {
    if (!outer.contains(v)) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const VertexId o : others) nearest = std::min(nearest, (mesh.position(o) - mesh.position(v)).norm());
    reach.emplace_back(nearest, v);
  }
  std::sort(reach.begin(), reach.end());
  const double distance = std::min(30 * mm, reach[reach.size() * 9 / 10].first);
  Support support;
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "the outer vertices of region %d that are %.0f mm or farther from the other regions",
                static_cast<int>(largest.label), std::floor(distance / mm));
  support.reason = text.data();
  for (const auto& [d, v] : reach)
    if (d >= std::floor(distance / mm) * mm) support.vertices.push_back(v);
  std::sort(support.vertices.begin(), support.vertices.end());
  return support;
}

Support upper_end(const LabelMesh& meshed) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : meshed.mesh.positions) box.extend(p);
  Support support;
  support.reason = "one organ alone is held at its upper end, the topmost tenth";
  box.min()[2] = box.max()[2] - 0.1 * box.sizes()[2];
  support.boxes.emplace_back(Vec3(box.min().array() - Eigen::Array3d(0.1 * mm, 0.1 * mm, 0)),
                             Vec3(box.max().array() + 0.1 * mm));
  support.box_reasons.push_back("upper end");
  return support;
}

TetMesh in_mm(const TetMesh& mesh) {
  TetMesh scaled = mesh;
  for (Vec3& p : scaled.positions) p /= mm;
  return scaled;
}

std::string corner(const Vec3& p, double round_to(double)) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "[%.1f, %.1f, %.1f]", round_to(p[0] / mm * 10) / 10,
                round_to(p[1] / mm * 10) / 10, round_to(p[2] / mm * 10) / 10);
  return text.data();
}

void write_supports(std::ostream& out, const Support& support) {
  out << "\n# Held: " << support.reason << ".\n";
  for (std::size_t b = 0; b < support.boxes.size(); ++b)
    out << "[[fixed]]  # " << support.box_reasons[b] << "\nbox = { min = " << corner(support.boxes[b].min(), std::floor)
        << ", max = " << corner(support.boxes[b].max(), std::ceil) << " }\n";
  if (support.vertices.empty()) return;
  out << "[[fixed]]\nvertices = [";
  for (std::size_t v = 0; v < support.vertices.size(); ++v)
    out << (v == 0 ? "\n  " : v % 20 == 0 ? ",\n  " : ", ") << support.vertices[v].value;
  out << "\n]\n";
}

void write_model(std::ostream& out, const LabelMesh& meshed, const std::string& source) {
  out << "# Made by calot mesh from " << source << ". Change what you like; calot precompute reads it.\n"
      << "mesh = \"mesh.msh\"      # coordinates: patient, right-anterior-superior\n"
      << "length_unit = \"mm\"     # of the mesh file and of the boxes below\n"
      << "time_step = 0.02       # s; 0 = static\n"
      << "\n# Regions:";
  for (const MeshedRegion& region : meshed.regions)
    out << ' ' << region.label << (region.name.empty() ? "" : " \"" + region.name + "\"")
        << (&region == &meshed.regions.back() ? "" : ",");
  out << "\n[[material]]\n"
      << "region = \"*\"           # a name or number above gives one region its own; later entries win\n"
      << "young = 1.0e6          # Pa; one stiffness for all, as in the published experiments this starts from\n"
      << "poisson = 0.45\n"
      << "density = 1000.0       # kg/m3\n";
  write_supports(out, choose_support(meshed));
}

}  // namespace

Support choose_support(const LabelMesh& meshed) {
  for (const MeshedRegion& region : meshed.regions)
    if (plain(region.name) == "common bile duct") return tube_ends(meshed, region);
  if (meshed.regions.size() == 1) return upper_end(meshed);
  return far_side(meshed,
                  *std::max_element(meshed.regions.begin(), meshed.regions.end(),
                                    [](const auto& a, const auto& b) { return a.quality.volume < b.quality.volume; }));
}

std::string file_name_of(const MeshedRegion& region) {
  std::string name = plain(region.name);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name.find_first_not_of('_') == std::string::npos ? "region_" + std::to_string(region.label) : name;
}

std::vector<std::string> label_mesh_files(const LabelMesh& meshed) {
  std::vector<std::string> files{"mesh.msh", "mesh.vtu"};
  for (const MeshedRegion& region : meshed.regions) {
    std::string name = file_name_of(region) + ".stl";
    if (std::find(files.begin(), files.end(), name) != files.end())
      name = file_name_of(region) + "_" + std::to_string(region.label) + ".stl";
    files.push_back(name);
  }
  files.insert(files.end(), {"quality.json", "model.toml"});
  return files;
}

void write_label_mesh(const std::filesystem::path& folder, const LabelMesh& meshed, const std::string& source) {
  const std::vector<std::string> files = label_mesh_files(meshed);
  const TetMesh scaled = in_mm(meshed.mesh);
  write_mesh(folder / "mesh.msh", scaled);
  write_mesh(folder / "mesh.vtu", scaled);
  for (std::size_t r = 0; r < meshed.regions.size(); ++r)
    write_surface(folder / files[2 + r], region_surface(scaled, meshed.regions[r].label));
  write_file(folder / "quality.json",
             [&](std::ostream& out) { out << detail::mesh_report(meshed, source).dump(2) << '\n'; });
  write_file(folder / "model.toml", [&](std::ostream& out) { write_model(out, meshed, source); });
}

}  // namespace calot
