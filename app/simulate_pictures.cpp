#include "app/simulate_pictures.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "app/arguments.h"
#include "calot/mesh/mesh_file.h"

namespace calot {
namespace {

namespace fs = std::filesystem;

const Vec3 steel{0.62, 0.66, 0.72}, clip_color{0.80, 0.83, 0.88}, cloth{0.86, 0.88, 0.86};

std::map<std::int32_t, Vec3> region_colors(const SceneRun& run) {
  std::map<std::int32_t, Vec3> colors;
  const TetMesh& mesh = run.world().model().mesh();
  for (const auto& [region, properties] : run.world().properties()) {
    const auto name = mesh.region_names.find(region);
    auto s = Structure::none;
    if (name != mesh.region_names.end()) s = structure_named(name->second).value_or(Structure::none);
    Appearance a = appearance_of(s == Structure::none ? Structure::hepatocystic_fat : s);
    if (run.patient())
      if (const auto own = run.patient()->appearances.find(s); own != run.patient()->appearances.end()) a = own->second;
    colors[region] = {a.red, a.green, a.blue};
  }
  return colors;
}

void append(Surface& all, const Surface& more) {
  const auto first = static_cast<std::uint32_t>(all.positions.size());
  all.positions.insert(all.positions.end(), more.positions.begin(), more.positions.end());
  for (const Triangle& t : more.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

/// A rounded plate's two faces; its edges are capsules.
void add_plate(Surface& all, const std::array<Vec3, 3>& corners, double radius) {
  const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  Surface faces;
  for (const double side : {1.0, -1.0})
    for (const Vec3& corner : corners) faces.positions.emplace_back(corner + side * radius * normal);
  faces.triangles = {{0, 1, 2}, {3, 5, 4}};
  append(all, faces);
}

void add_shape(Surface& all, const RigidShape& shape, const Pose& pose) {
  for (const RoundedPiece& piece : shape.pieces) {
    std::array<Vec3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = pose * piece.corners[i];
    if (piece.corner_count < 3) {
      append(all, capsule_surface(at[0], piece.corner_count == 2 ? at[1] : at[0], piece.radius));
      continue;
    }
    add_plate(all, at, piece.radius);
    for (std::size_t i = 0; i < 3; ++i) append(all, capsule_surface(at[i], at[(i + 1) % 3], piece.radius));
  }
}

Surface instruments_surface(const World& world) {
  Surface all;
  for (const InstrumentArm& arm : world.instruments()) {
    const InstrumentGeometry& geometry = arm.geometry();
    const ArticulatedPoses poses = articulate(geometry, arm.opening_to());
    add_shape(all, geometry.shaft, arm.to() * poses.shaft);
    add_shape(all, geometry.jaw_a, arm.to() * poses.jaw_a);
    add_shape(all, geometry.jaw_b, arm.to() * poses.jaw_b);
  }
  return all;
}

Surface clips_surface(const World& world) {
  Surface all;
  for (const Clip& clip : world.clips())
    if (clip.state() != ClipState::off) add_shape(all, clip.shape(), clip.frame());
  return all;
}

/// What a patient's pictures show: the gallbladder and what leaves it, with a hand's breadth around.
std::vector<Vec3> frame_points(const SceneRun& run) {
  const TetMesh& mesh = run.world().model().mesh();
  Eigen::AlignedBox3d box;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const auto s = static_cast<Structure>(mesh.regions[t]);
    if (run.patient() && s != Structure::gallbladder && s != Structure::cystic_duct) continue;
    for (const VertexId v : mesh.tets[t]) box.extend(mesh.positions[v.index()]);
  }
  const double room = std::max(0.005, 0.12 * box.sizes().norm());
  std::vector<Vec3> points;
  for (int corner = 0; corner < 8; ++corner)
    points.emplace_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) +
                        room *
                            Vec3((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1));
  return points;
}

}  // namespace

ScenePictures::ScenePictures(const Scene& scene, const SceneRun& run, fs::path png, fs::path vtu)
    : png_(std::move(png)), vtu_(std::move(vtu)), colors_(region_colors(run)), still_(load_surfaces(scene)) {
  for (const fs::path& folder : {png_, vtu_})
    if (!folder.empty()) make_output_folder(folder);
  options_.width = 960;
  options_.height = 720;
  options_.title = scene.title;
  options_.frame = PictureFrame{frame_points(run)};
  if (!run.patient()) return;
  const CameraPose& camera = run.patient()->landmarks.camera;
  const Vec3 gaze = camera.target - camera.tip;
  if (gaze.norm() > 0 && camera.up.cross(gaze).norm() > 1e-3 * gaze.norm())
    options_.direction = gaze, options_.up = camera.up;
}

void ScenePictures::write(const SceneRun& run) const {
  std::array<char, 40> name{};
  std::snprintf(name.data(), name.size(), "step_%06llu", static_cast<unsigned long long>(run.steps()));
  if (!png_.empty()) write_png(run, png_ / (std::string(name.data()) + ".png"));
  if (vtu_.empty()) return;
  const World& world = run.world();
  TetMesh mesh = world.model().mesh();
  VertexArray displacement{"displacement", 3, {}}, velocity{"velocity", 3, {}}, coagulation{"coagulation", 1, {}},
      temperature{"temperature", 1, {}};
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 moved = world.state().positions[v] - mesh.positions[v];
    const Vec3& speed = world.state().velocities[v];
    displacement.values.insert(displacement.values.end(), moved.begin(), moved.end());
    velocity.values.insert(velocity.values.end(), speed.begin(), speed.end());
    coagulation.values.push_back(world.heat().coagulation()[v]);
    temperature.values.push_back(world.heat().temperature(VertexId(v)));
  }
  mesh.positions = world.state().positions;
  write_mesh(vtu_ / (std::string(name.data()) + ".vtu"), mesh, {displacement, velocity, coagulation, temperature});
}

void ScenePictures::write_png(const SceneRun& run, const fs::path& path) const {
  const World& world = run.world();
  const Surface tissue = boundary_surface(world.model().mesh());
  const Surface tools = instruments_surface(world), clips = clips_surface(world);
  std::vector<PictureItem> items;
  if (!tissue.triangles.empty()) {
    PictureItem item;
    item.surface = &tissue;
    item.positions = world.state().positions;
    item.region_colors = colors_;
    items.push_back(item);
  }
  const auto add = [&](const Surface& surface, const Vec3& color) {
    if (surface.triangles.empty()) return;
    PictureItem item;
    item.surface = &surface;
    item.color = color;
    items.push_back(item);
  };
  add(tools, steel);
  add(clips, clip_color);
  for (const Surface& still : still_) add(still, cloth);
  PictureOptions options = options_;
  std::array<char, 60> caption{};
  std::snprintf(caption.data(), caption.size(), "%.2f s", world.time());
  options.caption = caption.data();
  write_picture(path, items, options);
}

}  // namespace calot
