// The texts of the interface by name.
#pragma once
#include <cstddef>
#include <cstdint>

namespace calot {

/// A text of the interface; its key in the file is its name with the first underscore as a dot ("step.count").
enum class Text : std::uint8_t {
  step_count,
  hand_left,
  hand_right,
  hand_empty,
  hand_open,
  hand_closed,
  hand_half_open,
  hand_holds_tissue,
  hand_holds_clip,
  hand_energy,
  hand_force,
  hand_too_much,
  instrument_bowel_grasper,
  instrument_curved_forceps,
  instrument_clip_applier,
  instrument_scissors,
  instrument_hook,
  instrument_suction,
  instrument_fan_retractor,
  count_blood,
  count_bile,
  count_clips,
  count_volume,
  command_pause,
  command_go_on,
  command_restart,
  command_settings,
  command_help,
  command_spectator,
  command_endoscope,
  command_picture,
  command_quit,
  command_close,
  command_cancel,
  pause_title,
  spectator_note,
  restart_question,
  restart_recording,
  settings_title,
  settings_quality,
  settings_quality_full,
  settings_quality_lite,
  settings_quality_none,
  settings_volume,
  settings_percent,
  settings_colors,
  settings_colors_usual,
  settings_colors_contrast,
  settings_text_size,
  settings_devices,
  settings_no_devices,
  settings_connected,
  settings_lost,
  help_title,
  help_begin,
  help_again,
};
constexpr std::size_t text_count = static_cast<std::size_t>(Text::help_again) + 1;

}  // namespace calot
