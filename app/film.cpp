#include "app/film.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <set>
#include <string>
#include <vector>

#include "app/arguments.h"
#include "calot/base/error.h"

extern char** environ;

namespace calot {
namespace {

namespace fs = std::filesystem;

/// Starts a program with its standard input from `in`, its output thrown away. Throws FailedError where it isn't there.
pid_t start(const std::vector<std::string>& words, int in) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (in >= 0)
    posix_spawn_file_actions_adddup2(&actions, in, 0);
  else
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  const int failure = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) throw FailedError("ffmpeg", "can't be started, and films are written by it", "install ffmpeg");
  return child;
}

bool succeeds(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return false;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::vector<std::string> coding_of(const std::string& ending) {
  if (ending == ".gif") return {};
  if (ending == ".webm") return {"-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-pix_fmt", "yuv420p"};
  return {"-c:v", "libx264", "-preset", "fast", "-crf", "18", "-pix_fmt", "yuv420p"};
}

}  // namespace

Film::Film(fs::path path, int width, int height, double pictures_per_second)
    : path_(std::move(path)), width_(width), height_(height) {
  const std::string ending = ending_of(path_);
  if (!std::set<std::string>{".mp4", ".mkv", ".webm", ".gif"}.contains(ending))
    throw InputError(path_.string(), "is no name of a film", "end it in .mp4, .mkv, .webm or .gif");
  if (width_ % 2 != 0 || height_ % 2 != 0)
    throw InputError("--size", "films need an even width and height", "give e.g. 1280x720");
  check_output_file(path_);
  part_ = path_.parent_path() / (path_.stem().string() + ".part" + ending);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw FailedError("ffmpeg", "no pipe to it could be made");
  std::vector<std::string> words{"ffmpeg",
                                 "-hide_banner",
                                 "-loglevel",
                                 "error",
                                 "-y",
                                 "-f",
                                 "rawvideo",
                                 "-pix_fmt",
                                 "rgb24",
                                 "-s",
                                 std::to_string(width_) + "x" + std::to_string(height_),
                                 "-r",
                                 std::to_string(pictures_per_second),
                                 "-i",
                                 "-"};
  for (const std::string& word : coding_of(ending)) words.push_back(word);
  words.push_back(part_.string());
  try {
    child_ = start(words, ends[0]);
  } catch (...) {
    close(ends[0]);
    close(ends[1]);
    throw;
  }
  close(ends[0]);
  pipe_ = ends[1];
}

Film::~Film() {
  if (child_ < 0) return;
  stop();
  std::error_code ignored;
  fs::remove(part_, ignored);
}

void Film::stop() {
  if (pipe_ >= 0) close(pipe_);
  pipe_ = -1;
  if (child_ >= 0) (void)succeeds(child_);
  child_ = -1;
}

void Film::add(const Image& image) {
  if (image.width != width_ || image.height != height_)
    throw FailedError(path_.string(), "a picture of another size came for the film");
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  std::size_t done = 0;
  while (done < image.rgb.size()) {
    const ssize_t written = write(pipe_, image.rgb.data() + done, image.rgb.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) break;
    done += static_cast<std::size_t>(written);
  }
  std::signal(SIGPIPE, before);
  if (done < image.rgb.size())
    throw FailedError(path_.string(), "ffmpeg ended before the film did", "is the disk full?");
}

void Film::finish(const fs::path& sound) {
  close(pipe_);
  pipe_ = -1;
  const bool whole = succeeds(child_);
  child_ = -1;
  std::error_code code;
  if (whole && !sound.empty() && ending_of(path_) != ".gif") {
    const fs::path joined = path_.parent_path() / (path_.stem().string() + ".sound" + path_.extension().string());
    const bool done = succeeds(start({"ffmpeg", "-hide_banner", "-loglevel", "error", "-y", "-i", part_.string(), "-i",
                                      sound.string(), "-c:v", "copy", "-shortest", joined.string()},
                                     -1));
    fs::remove(done ? part_ : joined, code);
    if (done) part_ = joined;
  }
  if (whole) fs::rename(part_, path_, code);
  if (!whole || code) {
    fs::remove(part_, code);
    throw FailedError(path_.string(), "ffmpeg could not write the film", "is the disk full?");
  }
}

}  // namespace calot
