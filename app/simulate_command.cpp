// calot simulate: a scene, headless; what happened, how long it took, and the same again from a recording.
#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/recorded_run.h"
#include "app/simulate_haptics.h"
#include "app/simulate_pictures.h"
#include "app/simulate_summary.h"
#include "app/stopwatch.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/compliance/blas.h"
#include "calot/scene/scene_file.h"

namespace calot {
namespace {

constexpr std::uint64_t most_told = 20;  // events of one kind on the screen
constexpr std::size_t most_listed = 10'000;

struct SimulateArguments {
  std::filesystem::path scene, record, replay, png, vtu;
  std::uint64_t steps = 0, every = 60;
  bool json = false, haptic_mock = false;
};

/// One run: the scene's world, and everything that watches it.
class Simulation {
 public:
  explicit Simulation(const SimulateArguments& arguments);
  void run();
  void report();

 private:
  void take_replay();
  void loop();
  void one_step();
  void watch();
  void compare();
  void tell(const WorldEvent& event);
  [[nodiscard]] bool pictured(std::uint64_t step) const;
  [[nodiscard]] std::string replay_text() const;

  const SimulateArguments& arguments_;
  Scene scene_;
  SceneRun run_;
  RunSummary summary_;
  std::uint64_t steps_ = 0;
  std::uint64_t mark_;  // steps from one recorded state to the next
  std::optional<Recording> recording_;
  ReplayResult replayed_;
  std::optional<MockHolder> hand_;
  std::optional<ScenePictures> pictures_;
  std::optional<InputRecorder> recorder_;
  nlohmann::ordered_json events_ = nlohmann::ordered_json::array();
  double wall_ = 0;
  bool stopped_ = false;
};

Simulation::Simulation(const SimulateArguments& arguments)
    : arguments_(arguments),
      scene_(read_scene(arguments.scene)),
      run_(scene_),
      summary_(run_.world()),
      steps_(arguments.steps > 0 ? arguments.steps : scene_.steps),
      mark_(std::max<std::uint64_t>(1, static_cast<std::uint64_t>(1 / scene_.time_step + 0.5))) {
  if (!arguments.replay.empty()) take_replay();
  if (steps_ == 0)
    throw InputError(arguments.scene.string(), "the scene doesn't say how long it runs",
                     "give --steps, or seconds in it");
  if (arguments.haptic_mock) hand_.emplace(scene_, run_);
  if (!arguments.png.empty() || !arguments.vtu.empty()) pictures_.emplace(scene_, run_, arguments.png, arguments.vtu);
  if (arguments.record.empty()) return;
  recorder_.emplace(arguments.record, recording_header(scene_, run_));
}

void Simulation::take_replay() {
  recording_ = read_recording_of(run_, arguments_.replay);
  const std::uint64_t there = recording_->steps.size();
  steps_ = arguments_.steps > 0 ? std::min(arguments_.steps, there) : there;
  replayed_.file = arguments_.replay.string();
}

bool Simulation::pictured(std::uint64_t step) const {
  return pictures_ && (step % arguments_.every == 0 || step == steps_);
}

void Simulation::one_step() {
  SceneRun::Inputs inputs = recording_ ? recording_->steps[run_.steps()] : run_.next_inputs();
  if (hand_) hand_->take(inputs);
  if (recorder_) recorder_->step(inputs);
  run_.step(std::move(inputs));
  if (hand_) hand_->give(run_.world());
}

void Simulation::tell(const WorldEvent& event) {
  if (events_.size() < most_listed) events_.push_back(event_json(event, run_.world()));
  if (arguments_.json) return;
  const std::uint64_t so_far = summary_.count(event.kind);
  if (so_far < most_told) return say(event_text(event, scene_.time_step));
  if (so_far == most_told) say(event_text(event, scene_.time_step) + " (further ones of this kind are counted only)");
}

void Simulation::compare() {
  const auto recorded = recording_->states.find(run_.steps());
  if (recorded == recording_->states.end()) return;
  ++replayed_.checked;
  replayed_.end_checked = recording_->complete && run_.steps() == recording_->steps.size();
  if (replayed_.differs_at == 0 && run_.world().state_hash() != recorded->second) replayed_.differs_at = run_.steps();
}

void Simulation::watch() {
  summary_.step(run_.world());
  for (const WorldEvent& event : run_.world().events()) tell(event);
  if (recorder_ && run_.steps() % mark_ == 0) recorder_->state(run_.world().state_hash());
  if (recording_) compare();
  if (pictured(run_.steps())) pictures_->write(run_);
}

void Simulation::loop() {
  Progress& progress = terminal_progress();
  progress.phase("simulate");
  while (run_.steps() < steps_) {
    if (progress.stop_requested()) {
      stopped_ = true;
      return;
    }
    Stopwatch watch_of_step;
    one_step();
    wall_ += watch_of_step.lap();
    watch();
    if (!progress.stop_requested()) progress.at(static_cast<double>(run_.steps()) / static_cast<double>(steps_));
  }
}

void Simulation::run() {
  if (!arguments_.json) {
    const TetMesh& mesh = run_.world().model().mesh();
    say((scene_.title.empty() ? arguments_.scene.string() : scene_.title) + ": " + std::to_string(mesh.vertex_count()) +
        " vertices, " + std::to_string(mesh.tet_count()) + " tets, " + std::to_string(scene_.instruments.size()) +
        " instruments; " + std::to_string(steps_) + " steps of " + number_text(1e3 * scene_.time_step) + " ms");
  }
  if (pictures_) pictures_->write(run_);
  try {
    loop();
  } catch (const Interrupted&) {
    stopped_ = true;
  }
  if (pictures_ && stopped_ && !pictured(run_.steps())) pictures_->write(run_);
  summary_.end(run_.world(), wall_);
  if (recorder_) recorder_->end(summary_.state_hash());
}

std::string Simulation::replay_text() const {
  if (!replayed_.same())
    return "the state is another than the recorded one after step " + std::to_string(replayed_.differs_at);
  return std::to_string(replayed_.checked) + " recorded states are the same to the last bit" +
         (replayed_.end_checked ? ", the end's too" : "; the recorded end wasn't reached");
}

void Simulation::report() {
  if (arguments_.json) {
    nlohmann::ordered_json json{{"scene", arguments_.scene.string()}, {"title", scene_.title},
                                {"calot_version", CALOT_VERSION},     {"kernel", blas::kernel_name()},
                                {"scene_sha256", run_.hash()},        {"completed", !stopped_}};
    json.update(summary_.json());
    if (hand_) json["haptics"] = hand_->json();
    if (recorder_) json["record"] = arguments_.record.string();
    if (recording_)
      json["replay"] = {{"file", replayed_.file},
                        {"same", replayed_.same()},
                        {"states_compared", replayed_.checked},
                        {"end_compared", replayed_.end_checked},
                        {"differs_after_step", replayed_.differs_at}};
    json["events"] = events_;
    std::cout << json.dump(2) << '\n';
  } else {
    say(summary_.text());
    if (hand_) say(hand_->text());
    if (recorder_) say("recorded in " + arguments_.record.string());
    if (recording_) say("replay: " + replay_text());
  }
  if (stopped_)
    throw FailedError(
        "", "stopped on request after step " + std::to_string(run_.steps()) + " of " + std::to_string(steps_));
  if (!replayed_.same()) throw FailedError(replayed_.file, replay_text(), "same program, same processor, same scene?");
}

void run_simulate(const SimulateArguments& arguments) {
  if (arguments.every == 0) throw InputError("--every", "is 0", "give 1 or more steps");
  if (arguments.haptic_mock && !arguments.replay.empty())
    throw InputError("--haptic-mock", "a recording says what the instruments do",
                     "leave out --haptic-mock or --replay");
  if (!arguments.record.empty()) check_output_file(arguments.record);
  Simulation simulation(arguments);
  simulation.run();
  simulation.report();
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("simulate", "Runs a scene without a window: what happened, and what each step took");
  const auto arguments = std::make_shared<SimulateArguments>();
  command->add_option("SCENE", arguments->scene, "scene.toml; examples/scenes has some")->required();
  command->add_option("--steps", arguments->steps, "so many instead of the scene's");
  command->add_option("--record", arguments->record, "writes what every instrument was asked into a new file");
  command->add_option("--replay", arguments->replay, "runs what was recorded, and says whether the state is the same");
  command->add_option("--png", arguments->png, "folder for pictures: the first step, the last and every so many");
  command->add_option("--vtu", arguments->vtu, "folder for meshes, for ParaView, of the same steps");
  command->add_option("--every", arguments->every, "steps from one picture or mesh to the next")->capture_default_str();
  command->add_flag("--json", arguments->json, "prints one JSON object on stdout");
  command->add_flag("--haptic-mock", arguments->haptic_mock,
                    "a mock hand holds the scene's [haptics] instrument, at 1 kHz against the clock");
  command->footer(
      "Examples: calot simulate examples/scenes/burn.toml --png out/burn --every 30\n"
      "          calot simulate examples/scenes/burn.toml --record burn.csv\n"
      "          calot simulate examples/scenes/burn.toml --replay burn.csv");
  command->callback([arguments] { run_simulate(*arguments); });
}

}  // namespace calot
