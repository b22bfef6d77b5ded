// The sounds of the operating room, made by the program: no recordings. Pure functions: same arguments, same samples.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace calot {

inline constexpr int kSampleRate = 48000;  ///< of every sound [1/s]

enum class SoundKind : std::uint8_t {
  // Once
  snip,             ///< scissors close: edges slide over each other, then meet
  clip,             ///< an applier's ratchet, then the clip shuts
  ratchet,          ///< a grasper's handle locks
  ratchet_release,  ///< and lets go
  exchange,         ///< an instrument goes through the trocar's valve
  slip,             ///< tissue slides out of jaws
  tear,             ///< tissue tears
  error,            ///< the program refuses or lost something
  attention,        ///< a hint or a new step
  beep,             ///< a heartbeat on the monitor
  // Without end
  cut_tone,       ///< the generator while it cuts
  coag_tone,      ///< the generator while it coagulates
  sizzle,         ///< water boiling out of tissue
  crackle,        ///< tissue bursting now and then
  crackle_dense,  ///< the same, often
  suction_air,    ///< the tube draws gas
  suction_fluid,  ///< the tube draws fluid
  alarm_low,      ///< bursts and the pauses between them, for each priority of IEC 60601-1-8
  alarm_medium,
  alarm_high,
  room,  ///< ventilation and machines
};
inline constexpr int kSoundKinds = static_cast<int>(SoundKind::room) + 1;

/// Every kind, in the order of the enumeration.
std::array<SoundKind, kSoundKinds> all_sounds();
/// As in the enumeration, with hyphens: "cut-tone".
std::string_view name_of(SoundKind kind);
/// Whether it goes on without end: then its last sample is followed by its first, with no seam.
bool loops(SoundKind kind);

struct SoundParameters {
  double saturation = 98;  ///< of the blood with oxygen, 0 … 100 [%]; for the beep
};

/// Mono at kSampleRate, within ±0.9, mean 0; a sound played once starts and ends with 0.
/// @param seed  another one gives another snip, another sizzle: same kind, other details. Tones don't depend on it.
std::vector<float> synthesise(SoundKind kind, std::uint64_t seed = 0, const SoundParameters& parameters = {});

/// Pitch of the heartbeat [Hz]: 880 Hz at 100 %, half a semitone lower for each per cent, so that equal falls sound
/// equal; the saturation is rounded to a whole per cent, as on the screen, and taken within 50 … 100. Makers' scales
/// differ, linear or logarithmic [Santamore2004]; a step of a per cent must be heard, which a third of listeners missed
/// on one of them [Schulte1992].
double beep_frequency(double saturation);

/// The bursts of an alarm [s], within the ranges of [Iec2006] Tables 3 and 4. A pulse lasts from 90 % of its amplitude
/// to 90 %, a space from there to the next pulse's 90 %.
struct AlarmBurst {
  int pulses = 0;
  double frequency = 0;           ///< of the first partial [Hz]
  double pulse = 0;               ///< duration
  double rise = 0;                ///< from 10 to 90 % of the amplitude; the fall takes as long
  std::array<double, 9> space{};  ///< after each pulse but the last
  double pause = 0;               ///< from the last pulse to the next burst
  double level = 0;               ///< amplitude
};
/// Of alarm_low, alarm_medium or alarm_high.
AlarmBurst alarm_burst(SoundKind kind);

}  // namespace calot
