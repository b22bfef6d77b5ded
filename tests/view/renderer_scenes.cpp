#include "tests/view/renderer_scenes.h"

namespace calot::test {

Scene gallbladder_scene() {
  Scene scene;
  TubeShape tube;
  for (const double x : {-28.0, -4.0, 2.0, 8.0, 14.0, 20.0, 26.0}) tube.points.push_back({x * millimetre, 0, 0});
  for (const double r : {1.6, 1.6, 3.2, 6.5, 8.0, 7.2, 3.4}) tube.radii.push_back(r * millimetre);
  tube.regions = {"cystic duct", "gallbladder", "gallbladder", "gallbladder", "gallbladder", "gallbladder"};
  tube.rings = 3;
  tube.fixed_first = tube.fixed_last = true;
  scene.tubes.push_back(tube);
  return scene;
}

Scene slab_scene(const std::string& region) {
  Scene scene;
  BlockShape block;
  block.region = region;
  block.size = Vec3(40, 40, 8) * millimetre;
  block.centre = Vec3(0, 0, -4) * millimetre;
  block.element_size = 4 * millimetre;
  block.fixed[4] = true;
  scene.blocks.push_back(block);
  return scene;
}

void add_instrument(Scene& scene, InstrumentKind kind, const Vec3& tip, const Vec3& direction, double opening) {
  SceneInstrument instrument;
  instrument.name = std::string(name_of(kind));
  instrument.kind = kind;
  InstrumentKey key;
  key.tip = tip;
  key.direction = direction.normalized();
  key.opening = opening;
  instrument.script.keys.push_back(key);
  scene.instruments.push_back(instrument);
}

Snapshot moment_of(const Scene& scene) {
  const SceneRun run(scene);
  SnapshotMaker maker(run.world());
  Snapshot out;
  maker.fill(run.world(), 0, out);
  return out;
}

Snapshot moment_after_cut(const Scene& scene, const std::function<bool(const Vec3&)>& gone) {
  World world(make_world_setup(scene, load_tissue(scene)));
  SnapshotMaker maker(world);
  const TetMesh& mesh = world.model().mesh();
  TopologyEdit edit;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (const VertexId v : mesh.tets[t]) middle += mesh.position(v) / 4;
    if (gone(middle)) edit.removed.emplace_back(t);
  }
  world.edit(edit, EventKind::cut, "for a picture");
  maker.follow(world);
  Snapshot out;
  maker.fill(world, 0, out);
  return out;
}

Camera usual_camera(float x, float distance) {
  const Eigen::Vector3f target(x * 1e-3F, 0, 0);
  return camera_looking(target + 1e-3F * distance * Eigen::Vector3f(0, -0.62F, 0.78F), target, {0, 0.6F, 0.8F});
}

}  // namespace calot::test
