// A scene with anything in it: a scene that can be written and read again, or an InputError. Small shapes are meshed
// too.
#include <cstddef>
#include <cstdint>
#include <sstream>

#include "calot/base/error.h"
#include "calot/scene/scene_file.h"
#include "calot/scene/shape_mesh.h"
#include "tests/support/files.h"

namespace {

const calot::test::TempFolder& folder_with_poses() {
  static const calot::test::TempFolder folder;
  static const bool written = [] {
    calot::test::write_bytes(folder / "p.csv", "time,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0,0,1,1,0,0,0\n");
    return true;
  }();
  (void)written;
  return folder;
}

void mesh_small_shapes(const calot::Scene& scene) {
  double tets = 0;
  for (const calot::BlockShape& block : scene.blocks) tets += 6 * (block.size / block.element_size).cwiseMax(1).prod();
  for (const calot::TubeShape& tube : scene.tubes)
    for (std::size_t s = 0; s + 1 < tube.points.size(); ++s)
      tets += 18.0 * tube.rings * tube.rings *
              (1 + (tube.points[s + 1] - tube.points[s]).norm() * tube.rings * 2 / (tube.radii[s] + tube.radii[s + 1]));
  if (tets < 2000) (void)calot::mesh_of_shapes(scene.blocks, scene.tubes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto path = folder_with_poses() / "scene.toml";
  calot::test::write_bytes(path, {reinterpret_cast<const char*>(data), size});
  calot::Scene scene;
  try {
    scene = calot::read_scene(path);
    mesh_small_shapes(scene);
  } catch (const calot::InputError&) {
    return 0;
  }
  for (const calot::SceneInstrument& tool : scene.instruments)
    for (const double time : {-1.0, 0.0, 0.3, 1e4})
      if (!calot::input_at(tool.script, 0.02, tool.port, time).pose.position.allFinite()) __builtin_trap();
  std::ostringstream out;
  calot::write_scene(out, scene);
  calot::test::write_bytes(path, out.str());
  // Throws, and so fails, if what was read can't be written.
  (void)calot::read_scene(path);
  return 0;
}
