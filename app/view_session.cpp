// calot view in a window: the world on its own thread, pictures and sounds on this one, which gives way to it.
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <optional>
#include <thread>

#include "app/live_run.h"
#include "app/terminal.h"
#include "app/view_arguments.h"
#include "app/view_camera.h"
#include "app/view_sounds.h"
#include "app/view_window.h"
#include "calot/base/error.h"
#include "calot/device/devices.h"
#include "calot/device/network.h"
#include "calot/device/sdl_events.h"
#include "calot/scene/scene_file.h"
#include "calot/sound/sound_player.h"
#include "calot/view/effects/effects.h"
#include "calot/view/interface/interface.h"

namespace calot {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int drawing_niceness = 19;            // the world, its background work and the hands come first
constexpr double shortest_picture = 1 / 120.0;  // [s]
constexpr double message_life = 6;              // [s]
constexpr float orbit_speed = 3;                // [rad] per height of the picture

std::optional<InterfaceCommand> command_of(Action action) {
  switch (action) {
    case Action::pause:
      return InterfaceCommand::pause;
    case Action::restart:
      return InterfaceCommand::restart;
    case Action::settings:
      return InterfaceCommand::settings;
    case Action::help:
      return InterfaceCommand::help;
    case Action::spectator:
      return InterfaceCommand::spectator;
    case Action::picture:
      return InterfaceCommand::picture;
    case Action::quit:
      return InterfaceCommand::quit;
    default:
      return std::nullopt;
  }
}

MessageKind kind_of(EventKind kind) {
  switch (kind) {
    case EventKind::torn:
    case EventKind::bleeding:
    case EventKind::leaking:
    case EventKind::clip_lost:
      return MessageKind::alarm;
    case EventKind::slipped:
    case EventKind::bruised:
    case EventKind::input_fault:
    case EventKind::ran_away:
      return MessageKind::caution;
    default:
      return MessageKind::note;
  }
}

bool is_told(EventKind kind) {
  return kind != EventKind::not_solved && kind != EventKind::overstretched && kind != EventKind::debris &&
         kind != EventKind::inverted;
}

InterfaceDevice device_of(const std::string& name) {
  return {name, true};
}

/// A display that goes away makes its library end the program: the recording gets its end even then.
class EndedWithTheProgram {
 public:
  explicit EndedWithTheProgram(LiveRun& run) {
    run_ = &run;
    std::atexit([] {
      if (run_ != nullptr) run_->stop();
    });
  }
  ~EndedWithTheProgram() { run_ = nullptr; }
  EndedWithTheProgram(const EndedWithTheProgram&) = delete;
  EndedWithTheProgram& operator=(const EndedWithTheProgram&) = delete;

 private:
  inline static LiveRun* run_ = nullptr;
};

/// One window on one scene.
class Session {
 public:
  explicit Session(const ViewArguments& arguments);
  void run();

 private:
  void take_events();
  void take_key(const SDL_Event& event);
  void act(Action action);
  void choose(int instrument);
  void fetch();
  void begin_run(const LiveFeed& feed);
  void aim();
  void draw();
  void obey(const InterfaceActions& actions);
  void save_picture();
  void describe();
  void list_keys();
  [[nodiscard]] LiveOptions live_options();
  void show_others();
  [[nodiscard]] std::optional<HandState> hand_state(int hand) const;
  [[nodiscard]] const Camera& camera() const { return state_.spectator ? outside_ : scope_; }

  const ViewArguments& arguments_;
  Scene scene_;
  ControlSettings settings_;
  Desktop desktop_;
  Gamepads pads_;
  std::optional<NetworkDevices> network_;
  std::array<std::unique_ptr<HapticDevice>, live_hands> mocks_;
  LiveRun live_;
  EndedWithTheProgram ended_{live_};
  Camera scope_, outside_;
  float orbit_distance_ = 0.1F;
  std::vector<Surface> still_;
  Window window_;
  std::unique_ptr<Renderer> renderer_;
  Interface interface_;
  std::optional<SoundPlayer> sounds_;
  ViewSounds heard_;
  LiveFeed feed_;
  const Snapshot* snapshot_ = nullptr;
  std::optional<Effects> effects_;
  InterfaceState state_;
  InterfaceInput input_;
  std::vector<bool InterfaceInput::*> pressed_, released_;  // since the last picture
  std::deque<InterfaceMessage> messages_;
  bool modal_ = false, open_ = true, fresh_ = false;
  std::uint64_t pictures_ = 0;
  double drawing_ = 0;
  int saved_ = 0;
  Clock::time_point last_ = Clock::now();
};

TextTable texts_of(const ViewArguments& arguments) {
  return arguments.text.empty() ? TextTable::english() : TextTable::load(arguments.text);
}

Session::Session(const ViewArguments& arguments)
    : arguments_(arguments),
      scene_(read_scene(arguments.scene)),
      settings_(arguments.controls.empty() ? ControlSettings{} : read_controls(arguments.controls)),
      desktop_(settings_, live_hands),
      pads_(settings_, live_hands),
      live_(scene_, desktop_, pads_, live_options()),
      scope_(live_.camera()),
      outside_(scope_),
      still_(load_surfaces(scene_)),
      window_(scene_.title.empty() ? "Calot" : "Calot: " + scene_.title, arguments.pixels().first,
              arguments.pixels().second),
      interface_(texts_of(arguments)) {
  // Only now: the world's threads are there and keep their priority; those of a driver that draws on the processor
  // begin with ours.
  setpriority(PRIO_PROCESS, 0, drawing_niceness);
  const PictureQuality usual = window_.draws_by_processor() ? PictureQuality::lite : PictureQuality::full;
  state_.settings.quality = arguments.picture_quality(usual);
  outside_.scope = false;
  state_.spectator = arguments.spectator;
  if (!arguments.mute) sounds_.emplace(SoundOptions{.volume = state_.settings.volume});
  if (!arguments.play)
    for (int hand = 0; hand < std::min<int>(live_hands, static_cast<int>(live_.tools().size())); ++hand) {
      live_.take(hand, hand);
      desktop_.hold(hand, live_.tools()[static_cast<std::size_t>(hand)]);
      pads_.hold(hand, live_.tools()[static_cast<std::size_t>(hand)]);
    }
  list_keys();
  interface_.show_help();
}

// What the page of keys shows; the same in every picture.
void Session::list_keys() {
  for (const BindingRow& row : desktop_.settings().bindings.rows())
    state_.controls.push_back({"", {row.keys}, row.words});
  for (const ActionInfo& info : all_actions())
    if (const auto command = command_of(info.action))
      if (const auto& keys = desktop_.settings().bindings.keys_of(info.action); !keys.empty())
        state_.command_keys[static_cast<std::size_t>(*command)] = std::string(name_of(keys.front()));
}

LiveOptions Session::live_options() {
  LiveOptions options{arguments_.play, arguments_.record};
  if (arguments_.device.empty()) return options;
  const DeviceChoice choice = read_device_choice(arguments_.device);
  if (choice.kind == DeviceKind::network) {
    NetworkOptions network;
    network.address = choice.address;
    network.port = choice.port;
    network_.emplace(network);
    say("waiting for manipulators at " + choice.address + ":" + std::to_string(network_->port()));
    options.force = {[this](int hand) -> HapticDevice& { return network_->device(hand); },
                     [this](int hand) { return network_->controls(hand); }};
  } else if (choice.kind == DeviceKind::mock) {
    for (auto& mock : mocks_) mock = make_mock_device(Pose{});
    options.force = {[this](int hand) -> HapticDevice& { return *mocks_[static_cast<std::size_t>(hand)]; },
                     [](int) { return HandControls{}; }};
  }
  return options;
}

// The organs, for other programs on the network.
void Session::show_others() {
  if (!network_) return;
  for (const std::string& line : network_->take_status()) messages_.push_back({line, MessageKind::note, 0});
  if (!fresh_) return;
  OrganSurface& surface = network_->next_surface();
  surface.topology = snapshot_->skin.version;
  surface.positions.assign(snapshot_->positions.begin(), snapshot_->positions.end());
  surface.triangles.assign(snapshot_->skin.triangles.begin(), snapshot_->skin.triangles.end());
  network_->publish_surface();
}

void Session::run() {
  while (open_ && !terminal_progress().stop_requested()) {
    const auto begin = Clock::now();
    live_.check();
    take_events();
    fetch();
    aim();
    show_others();
    draw();
    const double took = std::chrono::duration<double>(Clock::now() - begin).count();
    if (took < shortest_picture) std::this_thread::sleep_for(std::chrono::duration<double>(shortest_picture - took));
  }
  const LiveStatistics steps = live_.statistics();
  say(std::to_string(steps.steps) + " steps, p50 " + number_text(1e3 * steps.p50, 3) + " ms, p99 " +
      number_text(1e3 * steps.p99, 3) + " ms, longest " + number_text(1e3 * steps.longest, 3) + " ms; " +
      std::to_string(steps.late) + " late; " + std::to_string(pictures_) + " pictures, " +
      number_text(pictures_ > 0 ? 1e3 * drawing_ / static_cast<double>(pictures_) : 0, 3) + " ms each");
  if (!arguments_.record.empty()) say("recorded in " + arguments_.record.string());
}

void Session::choose(int instrument) {
  if (instrument < 0 || static_cast<std::size_t>(instrument) >= live_.tools().size()) return;
  const int hand = desktop_.active();
  live_.take(hand, instrument);
  desktop_.hold(hand, live_.tools()[static_cast<std::size_t>(instrument)]);
  pads_.hold(hand, live_.tools()[static_cast<std::size_t>(instrument)]);
}

void Session::act(Action action) {
  if (const auto command = command_of(action)) {
    input_.commands.push_back(*command);
    return;
  }
  const int first = static_cast<int>(Action::instrument_1), last = static_cast<int>(Action::instrument_9);
  const int number = static_cast<int>(action), count = static_cast<int>(live_.tools().size());
  if (number >= first && number <= last) choose(number - first);
  if (count == 0 || (action != Action::next_instrument && action != Action::previous_instrument)) return;
  const int step = action == Action::next_instrument ? 1 : count - 1;
  int next = std::max(0, live_.held_by(desktop_.active()));
  for (int tries = 0; tries < count; ++tries) {
    next = (next + step) % count;
    if (next != live_.held_by(1 - desktop_.active())) break;
  }
  choose(next);
}

// Keys of the interface that are down; one that went down and up again since the last picture counts as down once.
void Session::take_key(const SDL_Event& event) {
  static constexpr std::array<std::pair<SDL_Keycode, bool InterfaceInput::*>, 7> keys{
      {{SDLK_UP, &InterfaceInput::up},
       {SDLK_DOWN, &InterfaceInput::down},
       {SDLK_LEFT, &InterfaceInput::left},
       {SDLK_RIGHT, &InterfaceInput::right},
       {SDLK_TAB, &InterfaceInput::next},
       {SDLK_RETURN, &InterfaceInput::accept},
       {SDLK_SPACE, &InterfaceInput::accept}}};
  for (const auto& [key, member] : keys) {
    if (event.key.keysym.sym != key) continue;
    if (event.type == SDL_KEYDOWN) {
      input_.*member = true;
      pressed_.push_back(member);
    } else if (std::find(pressed_.begin(), pressed_.end(), member) != pressed_.end()) {
      released_.push_back(member);
    } else {
      input_.*member = false;
    }
  }
}

void Session::take_events() {
  input_.commands.clear();
  input_.wheel = 0;
  for (bool InterfaceInput::*member : released_) input_.*member = false;
  released_.clear();
  pressed_.clear();
  SDL_Event event;
  while (SDL_PollEvent(&event) != 0) {
    if (event.type == SDL_QUIT) open_ = false;
    if (event.type == SDL_KEYDOWN || event.type == SDL_KEYUP) take_key(event);
    if (event.type == SDL_MOUSEWHEEL) input_.wheel += event.wheel.preciseY;
    const bool free = modal_ || state_.paused;
    if (!free && state_.spectator && event.type == SDL_MOUSEMOTION) {
      const auto height = static_cast<float>(window_.height());
      outside_ = orbited(outside_, orbit_distance_, -orbit_speed * static_cast<float>(event.motion.xrel) / height,
                         -orbit_speed * static_cast<float>(event.motion.yrel) / height, 1);
      continue;
    }
    if (!free && state_.spectator && event.type == SDL_MOUSEWHEEL) {
      const float closer = std::pow(1.1F, event.wheel.preciseY);
      outside_ = orbited(outside_, orbit_distance_, 0, 0, closer);
      orbit_distance_ /= closer;
      continue;
    }
    const bool pointer = event.type == SDL_MOUSEMOTION || event.type == SDL_MOUSEWHEEL ||
                         event.type == SDL_MOUSEBUTTONDOWN || event.type == SDL_MOUSEBUTTONUP;
    if (free && pointer) continue;
    if (const auto action = feed(desktop_, event, std::max(1, window_.height())))
      if (!modal_ || command_of(*action)) act(*action);
  }
  for (const Action action : pads_.poll()) act(action);
}

void Session::begin_run(const LiveFeed& feed) {
  feed_ = feed;
  snapshot_ = feed_.snapshots->fetch();
  renderer_ = std::make_unique<Renderer>(state_.settings.quality);  // another run's masks are none of this one
  renderer_->set_surroundings(still_);
  renderer_->prepare(*snapshot_);
  effects_.emplace(*snapshot_, still_);
  heard_ = {};
  messages_.clear();
}

void Session::fetch() {
  const LiveFeed feed = live_.feed();
  fresh_ = false;
  if (feed.run != feed_.run) begin_run(feed);
  const Snapshot* newest = feed_.snapshots->fetch();
  if (newest == nullptr) return;
  snapshot_ = newest;
  fresh_ = true;
  effects_->advance(*snapshot_, snapshot_->step - effects_->state().step);
  for (const WorldEvent& event : snapshot_->events)
    if (is_told(event.kind))
      messages_.push_back({std::string(name_of(event.kind)) + ": " + event.text, kind_of(event.kind), 0});
}

// How the picture lies in the world, for the hands; and what is heard.
void Session::aim() {
  const Camera& seen = camera();
  PictureView view;
  Eigen::Matrix3f axes;
  axes << seen.right(), seen.up, -seen.forward;
  view.axes = Eigen::Quaterniond(Eigen::Quaternionf(axes));
  float distance = orbit_distance_;
  if (const int tool = live_.held_by(desktop_.active());
      tool >= 0 && static_cast<std::size_t>(tool) < snapshot_->instruments.size())
    distance =
        std::max(0.03F, (snapshot_->instruments[static_cast<std::size_t>(tool)].pose.position.cast<float>() - seen.eye)
                            .dot(seen.forward));
  view.height = 2 * distance * half_height(seen);
  desktop_.look(view);
  pads_.look(view);
  if (!sounds_) return;
  heard_.update(*snapshot_, seen);
  sounds_->update(heard_.scene(), fresh_ ? heard_.cues() : std::span<const SoundCue>{});
  if (const auto news = sounds_->news()) messages_.push_back({*news, MessageKind::note, 0});
}

std::optional<HandState> Session::hand_state(int hand) const {
  const int tool = live_.held_by(hand);
  if (tool < 0 || static_cast<std::size_t>(tool) >= snapshot_->instruments.size()) return std::nullopt;
  const InstrumentSnapshot& now = snapshot_->instruments[static_cast<std::size_t>(tool)];
  const InstrumentGeometry& geometry = live_.tools()[static_cast<std::size_t>(tool)];
  HandState state;
  state.kind = now.kind;
  state.opening = geometry.max_opening > 0 ? now.opening / geometry.max_opening : 0;
  state.energy = now.energy;
  state.holds_tissue = now.holds;
  state.holds_clip = now.holds_clip;
  state.force = now.force;
  return state;
}

void Session::describe() {
  state_.left = hand_state(0);
  state_.right = hand_state(1);
  state_.blood = snapshot_->blood_lost;
  state_.bile = snapshot_->bile_spilled;
  state_.time = snapshot_->time;
  state_.clips = static_cast<int>(std::count_if(snapshot_->clips.begin(), snapshot_->clips.end(),
                                                [](const ClipSnapshot& clip) { return clip.state != ClipState::off; }));
  state_.round_field = camera().scope;
  state_.devices.clear();
  for (const std::string& name : pads_.names()) state_.devices.push_back(device_of(name));
  while (!messages_.empty() && messages_.front().age > message_life) messages_.pop_front();
  state_.messages.assign(messages_.begin(), messages_.end());
}

void Session::draw() {
  const auto begin = Clock::now();
  input_.seconds = std::chrono::duration<double>(begin - last_).count();
  last_ = begin;
  for (InterfaceMessage& message : messages_) message.age += input_.seconds;
  describe();
  const Canvas canvas = window_.canvas();
  input_.pointer.reset();
  input_.pressed = false;
  if (!window_.grabbed()) {
    int x = 0, y = 0;
    input_.pressed = (SDL_GetMouseState(&x, &y) & SDL_BUTTON(SDL_BUTTON_LEFT)) != 0;
    input_.pointer = {x * window_.pixel_ratio(), y * window_.pixel_ratio()};
  }
  const InterfaceActions actions =
      interface_.lay_out(state_, input_, canvas.width, canvas.height, window_.pixel_ratio());
  renderer_->render(*snapshot_, effects_->state(), camera(), canvas, [this] { interface_.draw(); });
  window_.show();
  ++pictures_;
  drawing_ += std::chrono::duration<double>(Clock::now() - begin).count();
  obey(actions);
}

void Session::obey(const InterfaceActions& actions) {
  if (actions.pause) state_.paused = !state_.paused;
  if (actions.restart) {
    state_.paused = false;
    live_.restart();
  }
  if (actions.spectator) {
    state_.spectator = !state_.spectator;
    outside_ = scope_;
    outside_.scope = false;
  }
  if (actions.quit) open_ = false;
  if (actions.settings) {
    if (actions.settings->quality != state_.settings.quality) {
      renderer_ = std::make_unique<Renderer>(actions.settings->quality);
      renderer_->set_surroundings(still_);
    }
    if (sounds_) sounds_->set_volume(actions.settings->volume);
    state_.settings = *actions.settings;
  }
  if (actions.picture) save_picture();
  if (actions.modal != modal_ || actions.pause || actions.restart) {
    modal_ = actions.modal;
    desktop_.let_go();
  }
  live_.pause(state_.paused || modal_);
  window_.grab(!state_.paused && !modal_);
}

void Session::save_picture() {
  std::filesystem::path path;
  do path = "calot_" + std::to_string(++saved_) + ".png";
  while (std::filesystem::exists(path));
  const Canvas canvas = window_.canvas();
  const PictureCanvas picture(canvas.width, canvas.height);
  renderer_->render(*snapshot_, effects_->state(), camera(), picture.canvas());
  write_png(path, picture.read());
  messages_.push_back({"saved " + path.string(), MessageKind::note, 0});
}

}  // namespace

void view_in_window(const ViewArguments& arguments) {
  Session(arguments).run();
}

}  // namespace calot
