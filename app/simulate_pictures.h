// Pictures and meshes of a running scene, for `calot simulate --png` and `--vtu`.
#pragma once
#include <filesystem>
#include <map>
#include <vector>

#include "calot/picture/picture.h"
#include "calot/scene/scene_world.h"

namespace calot {

class ScenePictures {
 public:
  /// Frames what the scene shows at its start. Throws InputError for a folder that holds something already.
  ScenePictures(const Scene& scene, const SceneRun& run, std::filesystem::path png, std::filesystem::path vtu);
  /// step_000060.png and .vtu, where wanted.
  void write(const SceneRun& run) const;

 private:
  void write_png(const SceneRun& run, const std::filesystem::path& path) const;

  std::filesystem::path png_, vtu_;
  std::map<std::int32_t, Vec3> colors_;  // of regions
  std::vector<Surface> still_;
  PictureOptions options_;
};

}  // namespace calot
