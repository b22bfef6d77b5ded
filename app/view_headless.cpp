// calot view --headless: the same pictures as in the window, of every so many steps, and films.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/film.h"
#include "app/recorded_run.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "app/view_arguments.h"
#include "app/view_camera.h"
#include "app/view_sounds.h"
#include "calot/base/error.h"
#include "calot/scene/scene_file.h"
#include "calot/sound/sound_recorder.h"
#include "calot/sound/wav.h"
#include "calot/view/effects/effects.h"
#include "calot/view/gl/context.h"
#include "calot/view/snapshot_maker.h"

namespace calot {
namespace {

namespace fs = std::filesystem;

constexpr double usual_film_rate = 30;  // [1/s]

/// A run, and all that is seen and heard of it. Everything goes by steps, so that it is the same every time.
class Headless {
 public:
  explicit Headless(const ViewArguments& arguments)
      : arguments_(arguments),
        scene_(read_scene(arguments.scene)),
        run_(scene_),
        steps_(arguments.steps > 0 ? arguments.steps : scene_.steps),
        stride_(std::max<std::uint64_t>(
            1, static_cast<std::uint64_t>(std::lround(1 / usual_film_rate / scene_.time_step)))),
        camera_(scene_camera(scene_, run_)),
        still_(load_surfaces(scene_)),
        renderer_(arguments.picture_quality(PictureQuality::full)),
        canvas_(arguments.pixels().first, arguments.pixels().second),
        maker_(run_.world()) {
    if (!arguments.replay.empty()) take_replay();
    for (const std::uint64_t step : arguments.at)
      if (step > steps_)
        throw InputError("--at", "the run ends before step " + std::to_string(step),
                         "give steps up to " + std::to_string(steps_));
    if (steps_ == 0 && !arguments.video.empty())
      throw InputError(arguments.scene.string(), "the scene doesn't say how long it runs",
                       "give --steps, or seconds in it");
    camera_.scope = !arguments.spectator;
    renderer_.set_surroundings(still_);
    maker_.fill(run_.world(), 0, snapshot_);
    renderer_.prepare(snapshot_);
    effects_.emplace(snapshot_, still_);
    if (!arguments.png.empty()) make_output_folder(arguments.png);
    if (arguments.video.empty()) return;
    film_.emplace(arguments.video, canvas_.canvas().width, canvas_.canvas().height,
                  1 / (scene_.time_step * static_cast<double>(stride_)));
    if (!arguments.mute) sounds_.emplace();
  }

  void run() {
    Progress& progress = terminal_progress();
    progress.phase("view");
    show();
    while (run_.steps() < steps_ && !progress.stop_requested()) {
      step();
      show();
      progress.at(static_cast<double>(run_.steps()) / static_cast<double>(steps_));
    }
    const bool stopped = run_.steps() < steps_;
    finish();
    if (stopped)
      throw FailedError("", "stopped on request after step " + std::to_string(run_.steps()) + " of " +
                                std::to_string(steps_) + "; what was made until then is there");
  }

 private:
  void take_replay() {
    recording_ = read_recording_of(run_, arguments_.replay);
    const std::uint64_t there = recording_->steps.size();
    steps_ = arguments_.steps > 0 ? std::min(arguments_.steps, there) : there;
  }

  void step() {
    run_.step(recording_ ? recording_->steps[run_.steps()] : run_.next_inputs());
    maker_.follow(run_.world());
    maker_.fill(run_.world(), events_, snapshot_);
    events_ = maker_.events_seen();
    maker_.forget_events(events_);
    effects_->advance(snapshot_, 1);
    if (!sounds_) return;
    cues_.update(snapshot_, camera_);
    sounds_->update(cues_.scene(), cues_.cues());
    const auto due = static_cast<std::size_t>(std::llround(run_.world().time() * kSampleRate));
    const std::vector<std::int16_t> heard = sounds_->render(due - samples_.size() / 2);
    samples_.insert(samples_.end(), heard.begin(), heard.end());
  }

  [[nodiscard]] bool is_wanted(bool last) const {
    if (arguments_.at.empty()) return run_.steps() % arguments_.every == 0 || last;
    return std::find(arguments_.at.begin(), arguments_.at.end(), run_.steps()) != arguments_.at.end();
  }

  void show() {
    const bool last = run_.steps() == steps_;
    const bool pictured = !arguments_.png.empty() && is_wanted(last);
    const bool filmed = film_ && run_.steps() % stride_ == 0;
    if (!pictured && !filmed) return;
    Stopwatch watch;
    renderer_.render(snapshot_, effects_->state(), camera_, canvas_.canvas());
    const Image image = canvas_.read();
    drawing_ += watch.lap();
    ++pictures_;
    if (filmed) film_->add(image);
    if (!pictured) return;
    char name[40];
    std::snprintf(name, sizeof name, "step_%06llu.png", static_cast<unsigned long long>(run_.steps()));
    write_png(arguments_.png / name, image);
    ++files_;
  }

  void finish() {
    if (film_) {
      fs::path sound;
      if (sounds_) {
        sound = arguments_.video.parent_path() / (arguments_.video.stem().string() + ".part.wav");
        write_wav(sound, samples_, 2);
      }
      film_->finish(sound);
      std::error_code ignored;
      if (!sound.empty()) fs::remove(sound, ignored);
      say("film: " + arguments_.video.string());
    }
    if (!arguments_.png.empty()) say(std::to_string(files_) + " pictures in " + arguments_.png.string());
    say(std::to_string(run_.steps()) + " steps, " + std::to_string(pictures_) + " pictures of " +
        std::to_string(canvas_.canvas().width) + " x " + std::to_string(canvas_.canvas().height) + ", " +
        std::string(name_of(renderer_.quality())) + ", " +
        number_text(pictures_ > 0 ? 1e3 * drawing_ / static_cast<double>(pictures_) : 0, 3) + " ms each (" +
        driver_name() + ")");
  }

  const ViewArguments& arguments_;
  Scene scene_;
  SceneRun run_;
  std::uint64_t steps_, stride_;
  std::optional<Recording> recording_;
  Camera camera_;
  std::vector<Surface> still_;
  OffscreenContext context_;
  Renderer renderer_;
  PictureCanvas canvas_;
  SnapshotMaker maker_;
  Snapshot snapshot_;
  std::uint64_t events_ = 0;
  std::optional<Effects> effects_;
  std::optional<Film> film_;
  std::optional<SoundRecorder> sounds_;
  ViewSounds cues_;
  std::vector<std::int16_t> samples_;
  std::size_t pictures_ = 0, files_ = 0;
  double drawing_ = 0;
};

}  // namespace

void view_headless(const ViewArguments& arguments) {
  if (arguments.every == 0) throw InputError("--every", "is 0", "give 1 or more steps");
  if (arguments.png.empty() && arguments.video.empty())
    throw InputError("--headless", "nothing is to be written", "add --png FOLDER or --video FILE.mp4");
  Headless(arguments).run();
}

}  // namespace calot
