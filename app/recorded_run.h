// Recordings of a scene's runs, as the commands read and write them.
#pragma once
#include "calot/scene/recording.h"
#include "calot/scene/scene_world.h"

namespace calot {

/// What the file begins with.
RecordingHeader recording_header(const Scene& scene, const SceneRun& run);
/// Reads a recording of this scene. Throws InputError for one of another scene or without steps; warns of another
/// version, another kernel and a missing end.
Recording read_recording_of(const SceneRun& run, const std::filesystem::path& file);

}  // namespace calot
