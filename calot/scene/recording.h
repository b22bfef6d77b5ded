// What instruments were asked, step by step, as a file: docs/formats.md, "Recordings".
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calot/sim/instrument.h"

namespace calot {

struct RecordingHeader {
  std::string version;     ///< of Calot
  std::string scene;       ///< its file, as it was named
  std::string scene_hash;  ///< SceneRun::hash
  std::string kernel;      ///< what computes; other kernels round otherwise
  double time_step = 0;    ///< [s]
  std::vector<std::string> instruments;
};

/// Writes while a run goes on: after a crash, all but the last half second is in the file.
class InputRecorder {
 public:
  /// Throws InputError for a file that is there already, FailedError where it can't be written.
  InputRecorder(std::filesystem::path path, const RecordingHeader& header);
  ~InputRecorder();
  InputRecorder(const InputRecorder&) = delete;
  InputRecorder& operator=(const InputRecorder&) = delete;

  /// The inputs of the next step; empty ones leave no line. Throws FailedError for a full disk.
  void step(const std::vector<std::optional<InstrumentInput>>& inputs);
  /// The state's hash after the last step.
  void state(const std::string& hash);
  /// The last line: the state's hash after the last step. Flushes.
  void end(const std::string& hash);

 private:
  void flush();

  std::filesystem::path path_;
  int file_ = -1;
  std::string buffer_;
  std::uint64_t steps_ = 0;
  std::chrono::steady_clock::time_point flushed_;
};

struct Recording {
  RecordingHeader header;
  std::vector<std::vector<std::optional<InstrumentInput>>> steps;  ///< of each step, of each instrument
  std::map<std::uint64_t, std::string> states;                     ///< hashes after some steps
  bool complete = false;                                           ///< it was ended; `states` has the last step's
};

/// Reads one; the last line may be cut off. Throws InputError naming file and line for anything else that is wrong.
Recording read_recording(const std::filesystem::path& path);

}  // namespace calot
