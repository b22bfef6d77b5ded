// What the interface is told, and what it answers.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calot/sim/instrument.h"
#include "calot/view/renderer.h"

namespace calot {

enum class InterfaceColors : std::uint8_t {
  usual,     ///< the palette that colour-blind people tell apart [Okabe2008], dimmed
  contrast,  ///< lighter, on opaque black
};

struct InterfaceSettings {
  PictureQuality quality = PictureQuality::full;
  double volume = 0.7;  ///< 0 … 1
  InterfaceColors colors = InterfaceColors::usual;
  double text_scale = 1;  ///< 0.75 … 2
  friend bool operator==(const InterfaceSettings&, const InterfaceSettings&) = default;
};

struct HandState {
  InstrumentKind kind = InstrumentKind::bowel_grasper;
  double opening = 0;  ///< share of the largest, 0 … 1; ignored for instruments without jaws
  bool energy = false, holds_tissue = false, holds_clip = false;
  double force = 0;         ///< [N]
  double force_limit = 10;  ///< beyond it there is a warning [N]
};

enum class MessageKind : std::uint8_t { note, caution, alarm };

struct InterfaceMessage {
  std::string text;
  MessageKind kind = MessageKind::note;
  double age = 0;  ///< [s]; old ones fade
};

struct InterfaceDevice {
  std::string name;
  bool connected = false;
};

/// A line of the page of keys.
struct InterfaceControl {
  std::string name;               ///< key of [controls] in the text file; may be empty
  std::vector<std::string> keys;  ///< "w", "left ctrl", "mouse left", "mouse", "wheel" …; "a, b" are two
  std::string words;              ///< in English; the text file's are shown if it knows them
};

enum class InterfaceCommand : std::uint8_t { pause, restart, settings, help, spectator, picture, quit };
constexpr std::size_t interface_command_count = 7;

struct InterfaceState {
  int step_number = 0, step_count = 0;  ///< 0: none
  std::string step, hint;
  std::optional<HandState> left, right;
  double blood = 0, bile = 0;  ///< [m³]
  double time = 0;             ///< since the start [s]
  int clips = 0;               ///< on tissue
  bool paused = false, spectator = false;
  bool round_field = true;  ///< the picture is round: its corners are free
  InterfaceSettings settings;
  std::vector<InterfaceDevice> devices;
  std::vector<InterfaceMessage> messages;  ///< the newest last
  std::vector<InterfaceControl> controls;
  std::array<std::string, interface_command_count> command_keys;  ///< what is printed on the key of each command
};

/// Mouse and keys since the last picture.
struct InterfaceInput {
  double seconds = 1.0 / 60;                     ///< since the last picture
  std::optional<std::array<double, 2>> pointer;  ///< [pixels] from the top left; none while it drives an instrument
  bool pressed = false;                          ///< the left button is down
  double wheel = 0;                              ///< notches, up is positive
  std::vector<InterfaceCommand> commands;        ///< whose keys went down
  bool up = false, down = false, left = false, right = false, next = false, accept = false;  ///< keys that are down
};

/// What the user wants; each is said once.
struct InterfaceActions {
  bool pause = false;      ///< pause, or go on
  bool restart = false;    ///< after a question
  bool spectator = false;  ///< look from outside, or through the endoscope
  bool picture = false, quit = false;
  bool help_closed = false;                   ///< the page of keys has been read
  std::optional<InterfaceSettings> settings;  ///< changed to this
  /// A page is open: the world stands still, and mouse and keys are the interface's.
  bool modal = false;
};

}  // namespace calot
