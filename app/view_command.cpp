// calot view: a scene to be seen, heard and handled.
#include <memory>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/terminal.h"
#include "app/view_arguments.h"
#include "calot/base/error.h"
#include "calot/device/devices.h"

namespace calot {

std::pair<int, int> ViewArguments::pixels() const {
  if (size.empty()) return {1280, 720};
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(size.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 64 || height < 64 || width > 8192 ||
      height > 8192)
    throw InputError("--size", "\"" + size + "\" is no size of a picture", "give e.g. 1280x720; 64 to 8192 each");
  return {width, height};
}

PictureQuality ViewArguments::picture_quality(PictureQuality usual) const {
  if (quality.empty()) return usual;
  for (const PictureQuality q : {PictureQuality::full, PictureQuality::lite, PictureQuality::none})
    if (quality == name_of(q)) return q;
  throw InputError("--quality", "\"" + quality + "\" isn't one", "give full, lite or none");
}

namespace {

void tell_devices() {
  for (const DeviceInfo& device : list_devices())
    say(device.choice + ": " + device.words + (device.present ? "" : " (not there)"));
}

}  // namespace

void add_view_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("view", "Opens a scene to be seen, heard and handled; or pictures and a film of it");
  const auto arguments = std::make_shared<ViewArguments>();
  command->add_option("SCENE", arguments->scene, "scene.toml; examples/scenes has some");
  command->add_flag("--play", arguments->play, "the scene's scripts move the instruments until a hand takes them");
  command->add_option("--quality", arguments->quality,
                      "full, lite or none; in a window without a graphics card lite, else full");
  command->add_option("--size", arguments->size, "of the window or the pictures, WIDTHxHEIGHT [1280x720]");
  command->add_flag("--spectator", arguments->spectator, "the whole rectangle instead of a laparoscope's round field");
  command->add_flag("--mute", arguments->mute, "no sound");
  command->add_option("--record", arguments->record, "writes what every instrument was asked into a new file");
  command->add_option("--device", arguments->device,
                      "network or network:ADDRESS:PORT for manipulators by OpenIGTLink, mock for a simulated hand; "
                      "mouse, keyboard and gamepads need none");
  command->add_flag("--list-devices", arguments->list_devices, "says which devices there are, and ends");
  command->add_option("--controls", arguments->controls, "a file that changes keys and speeds; docs/devices.md");
  command->add_option("--text", arguments->text, "a file with the interface's words in another language; docs/view.md");
  command->add_flag("--headless", arguments->headless, "no window: writes what --png and --video name");
  command->add_option("--replay", arguments->replay, "headless: what was recorded instead of the scripts");
  command->add_option("--png", arguments->png,
                      "headless: folder for pictures: the first step, the last and every so many");
  command->add_option("--every", arguments->every, "steps from one picture to the next")->capture_default_str();
  command->add_option("--at", arguments->at, "headless: pictures of these steps instead, e.g. --at 60,240")
      ->delimiter(',');
  command->add_option("--video", arguments->video,
                      "headless: a film with sound, .mp4, .mkv, .webm or .gif; needs ffmpeg");
  command->add_option("--steps", arguments->steps, "headless: so many instead of the scene's");
  command->footer(
      "Examples:\n"
      "  calot view examples/scenes/clip_and_cut.toml\n"
      "  calot view examples/scenes/clip_and_cut.toml --play\n"
      "  calot view examples/scenes/burn.toml --headless --png pictures --every 30\n"
      "  calot view examples/scenes/clip_and_cut.toml --headless --video film.mp4 --size 1280x720");
  command->callback([arguments] {
    if (arguments->list_devices) return tell_devices();
    if (arguments->scene.empty())
      throw InputError("SCENE", "is missing", "name a scene.toml; examples/scenes has some");
    if (arguments->headless) return view_headless(*arguments);
    for (const auto& [name, given] : {std::pair{"--png", !arguments->png.empty()},
                                      {"--video", !arguments->video.empty()},
                                      {"--replay", !arguments->replay.empty()},
                                      {"--steps", arguments->steps > 0}})
      if (given) throw InputError(name, "is for pictures without a window", "add --headless");
    view_in_window(*arguments);
  });
}

}  // namespace calot
