// A patient made of cubes of 5 mm: small, but with everything that a folder holds, and nothing wrong.
#pragma once
#include <algorithm>

#include "calot/patient/patient.h"
#include "tests/support/meshes.h"
#include "tests/support/volumes.h"

namespace calot::test {

constexpr double cube = 5e-3;
const Vec3 corner_of_cubes(0.030, -0.060, 0.100);

/// Which structure the cube (i, j, k) of 12 × 6 × 8 belongs to.
inline Structure structure_of_cube(int i, int j, int k) {
  if (k >= 5) return Structure::liver;
  if (i >= 8 && i <= 10 && j >= 2 && j <= 3 && k >= 3) return Structure::gallbladder;
  if (i == 3 && j == 2) return k == 4 ? Structure::common_hepatic_duct : Structure::common_bile_duct;
  if (i < 4 || i > 7) return Structure::none;
  if (j == 2 && k == 3) return Structure::cystic_duct;
  if (j == 2 && k == 4) return Structure::hepatocystic_fat;
  if (j == 3 && k == 4) return Structure::cystic_artery;
  return Structure::none;
}

/// The middle of a cube; fractions are places within it.
inline Vec3 cube_place(double i, double j, double k) {
  return corner_of_cubes + cube * Vec3(i, j, k);
}

inline TubeSite site_on(const Centreline& line, const std::string& name, double arc_length) {
  const LinePlace place = place_at(line, arc_length);
  return {name, *structure_named(line.name), arc_length, place.point, place.direction, place.radius};
}

inline TetMesh small_mesh() {
  TetMesh mesh = cell_mesh(12, 6, 8, {12 * cube, 6 * cube, 8 * cube},
                           [](int i, int j, int k) { return static_cast<int>(structure_of_cube(i, j, k)); });
  for (Vec3& p : mesh.positions) p += corner_of_cubes;
  mesh.region_names.clear();
  for (const std::int32_t region : mesh.regions)
    mesh.region_names[region] = std::string(name_of(static_cast<Structure>(region)));
  return mesh;
}

inline std::vector<VertexId> vertices_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& chosen) {
  std::vector<VertexId> vertices;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    if (chosen(mesh.positions[v])) vertices.emplace_back(v);
  return vertices;
}

inline Landmarks small_landmarks(const std::vector<Centreline>& lines) {
  Landmarks marks;
  const Vec3 centre = (cube_place(3.5, 2.5, 3.5) + cube_place(8, 2.5, 3.5) + cube_place(3.5, 2.5, 5)) / 3;
  marks.triangle = {cube_place(3.5, 2.5, 3.5), cube_place(8, 2.5, 3.5), cube_place(3.5, 2.5, 5)};
  marks.ports = {{"camera", centre + Vec3(0.02, 0.14, -0.10), 10e-3, "laparoscope"},
                 {"epigastric", centre + Vec3(-0.07, 0.15, 0.02), 10e-3, "dissector, clips"},
                 {"midclavicular", centre + Vec3(0.06, 0.15, -0.01), 5e-3, "grasper \"left\""},
                 {"anterior axillary", centre + Vec3(0.13, 0.10, -0.03), 5e-3, "grasper of the fundus"}};
  marks.camera = {centre + Vec3(0.0, 0.08, -0.05), centre, Vec3(0, 0, 1), 30, 70};
  for (Centreline line : lines) {
    if (line.name != "cystic duct" && line.name != "cystic artery") continue;
    if (line.points.front().x() > line.points.back().x()) {
      std::reverse(line.points.begin(), line.points.end());
      std::reverse(line.radii.begin(), line.radii.end());
    }
    for (const int c : {1, 2, 3})
      marks.clips.push_back(
          site_on(line, line.name + ", clip " + std::to_string(c), (3 + 4 * c + (c == 3 ? 2 : 0)) * 1e-3));
    marks.cuts.push_back(site_on(line, line.name + ", cut", 14e-3));
  }
  marks.notes = {"the skin isn't in the CT: ports lie on an assumed wall"};
  return marks;
}

inline Patient small_patient() {
  Patient patient;
  patient.name = "cubes, \"small\"";
  patient.mesh = small_mesh();
  for (const auto& [region, name] : patient.mesh.region_names) {
    const auto s = static_cast<Structure>(region);
    patient.materials[s] = material_of(s);
    patient.appearances[s] = appearance_of(s);
  }
  // The duct runs the other way round in the file than towards the gallbladder.
  patient.lines = {{"cystic duct",
                    {cube_place(8, 2.5, 3.5), cube_place(5, 2.5, 3.5), cube_place(3.5, 2.5, 3.5)},
                    {2.0e-3, 1.9e-3, 1.8e-3}},
                   {"cystic artery", {cube_place(4, 3.5, 4.5), cube_place(8, 3.5, 4.5)}, {1e-3, 1e-3}},
                   {"common bile duct", {cube_place(3.5, 2.5, 0), cube_place(3.5, 2.5, 4)}, {2.5e-3, 2.5e-3}}};
  const double top = corner_of_cubes.z() + 8 * cube - 1e-6, bottom = corner_of_cubes.z() + 1e-6;
  patient.attachments = {
      {"liver: bare area", AttachmentKind::fixed,
       vertices_where(patient.mesh, [&](const Vec3& p) { return p.z() > top; }), "the diaphragm holds it"},
      {"common bile duct: lower end", AttachmentKind::fixed,
       vertices_where(patient.mesh, [&](const Vec3& p) { return p.z() < bottom; }), "the duodenum holds it"},
      {"gallbladder: peritoneum", AttachmentKind::peritoneum,
       vertices_where(patient.mesh,
                      [&](const Vec3& p) {
                        return std::abs(p.z() - cube_place(0, 0, 5).z()) < 1e-6 &&
                               p.x() > cube_place(8, 0, 0).x() - 1e-6 && p.x() < cube_place(11, 0, 0).x() + 1e-6;
                      }),
       "runs over both"}};
  patient.border_cuts = {{Structure::liver, 2, true, cube_place(6, 3, 8), Vec3(0, 0, 1), 1.8e-3}};
  patient.landmarks = small_landmarks(patient.lines);
  return patient;
}

inline LabelMesh small_label_mesh(const Patient& patient) {
  LabelMesh meshed;
  meshed.mesh = patient.mesh;
  meshed.quality = quality(patient.mesh);
  meshed.outer = check_manifold(boundary_surface(patient.mesh));
  meshed.tries = 1;
  for (const auto& [region, name] : patient.mesh.region_names) {
    MeshedRegion each;
    each.label = static_cast<Label>(region);
    each.name = name;
    each.quality = quality(patient.mesh, region);
    each.voxel_volume = each.quality.volume;
    each.voxels = 1;
    meshed.regions.push_back(each);
  }
  return meshed;
}

inline CompletedAnatomy small_anatomy(const Patient& patient) {
  CompletedAnatomy anatomy;
  VoxelGrid grid;
  grid.size = {14, 8, 10};
  grid.to_world = Eigen::Translation3d(cube_place(-0.5, -0.5, -0.5)) * Eigen::Scaling(cube);
  anatomy.labels = map_of(grid, [](int i, int j, int k) {
    const bool inside = i >= 1 && j >= 1 && k >= 1 && i <= 12 && j <= 6 && k <= 8;
    return inside ? label_of(structure_of_cube(i - 1, j - 1, k - 1)) : Label{0};
  });
  anatomy.labels.names = structure_names();
  anatomy.lines = patient.lines;
  anatomy.border_cuts = patient.border_cuts;
  anatomy.warnings = {"the liver is cut by the CT's upper border"};
  return anatomy;
}

inline Provenance small_provenance() {
  return {{{"CT", "ct.nii.gz", std::string(64, 'a')}, {"labels", "labels \"2\".nii.gz", std::string(64, 'b')}},
          {{"calot", "9.8.7"}, {"CGAL", "5.5"}},
          {{"tets", "20000"}, {"spacing", "0.7 mm"}},
          {{"closing", Structure::liver, 12, 3, 0.012, 0.003, "radius 1 mm"}}};
}

inline void write_small_patient(const std::filesystem::path& folder, const Patient& patient = small_patient()) {
  write_patient(folder, patient, small_label_mesh(patient), small_anatomy(patient), small_provenance());
}

}  // namespace calot::test
