#include "app/recorded_run.h"

#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/compliance/blas.h"

namespace calot {

RecordingHeader recording_header(const Scene& scene, const SceneRun& run) {
  RecordingHeader header{CALOT_VERSION, scene.file.string(), run.hash(), blas::kernel_name(), scene.time_step, {}};
  for (const SceneInstrument& tool : scene.instruments) header.instruments.push_back(tool.name);
  return header;
}

Recording read_recording_of(const SceneRun& run, const std::filesystem::path& path) {
  Recording recording = read_recording(path);
  const RecordingHeader& header = recording.header;
  const std::string file = path.string();
  if (header.scene_hash != run.hash())
    throw InputError(file, "was recorded from another scene, or from this one before it was changed",
                     "give the scene that it was recorded from: " + header.scene);
  if (recording.steps.empty()) throw InputError(file, "has no steps", "record it again");
  if (header.version != CALOT_VERSION || header.kernel != blas::kernel_name())
    warn(file + " was recorded by calot " + header.version + " on " + header.kernel +
         ", this is calot " CALOT_VERSION " on " + blas::kernel_name() +
         ": the last digits, and so the state, may differ");
  if (!recording.complete) warn(file + " has no end: what was recorded of the run is run again");
  return recording;
}

}  // namespace calot
