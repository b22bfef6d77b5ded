// Films: pictures one after another into ffmpeg.
#pragma once
#include <sys/types.h>

#include <filesystem>

#include "calot/picture/picture.h"

namespace calot {

/// Writes a film while its pictures are made. The file appears when `finish` is done; without it nothing is left.
class Film {
 public:
  /// Throws FailedError where ffmpeg isn't there, InputError for a name it has no format for (.mp4, .mkv, .webm, .gif).
  Film(std::filesystem::path path, int width, int height, double pictures_per_second);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// A picture of the film's size. Throws FailedError when ffmpeg gave up.
  void add(const Image& image);
  /// @param sound  a WAV file as long as the film, or empty
  void finish(const std::filesystem::path& sound = {});

 private:
  void stop();
  std::filesystem::path path_, part_;
  int width_, height_, pipe_ = -1;
  pid_t child_ = -1;
};

}  // namespace calot
