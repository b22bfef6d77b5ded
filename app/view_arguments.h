// What `calot view` was asked.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calot/view/renderer.h"

namespace calot {

struct ViewArguments {
  std::filesystem::path scene, png, video, replay, record, controls, text;
  std::uint64_t steps = 0, every = 60;
  std::vector<std::uint64_t> at;  ///< steps to be pictured; empty: every so many
  std::string size, quality, device;
  bool headless = false, play = false, mute = false, spectator = false, list_devices = false;

  /// Width and height of the pictures, and their quality. Throw InputError naming the option.
  [[nodiscard]] std::pair<int, int> pixels() const;
  [[nodiscard]] PictureQuality picture_quality(PictureQuality usual) const;
};

/// Runs the scene without a window and writes pictures and a film of it.
void view_headless(const ViewArguments& arguments);
/// Opens a window on the scene, to be handled freely.
void view_in_window(const ViewArguments& arguments);

}  // namespace calot
