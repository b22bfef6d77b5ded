#include "calot/sound/sounds.h"

#include "calot/sound/kinds.h"

namespace calot {

std::array<SoundKind, kSoundKinds> all_sounds() {
  std::array<SoundKind, kSoundKinds> all{};
  for (int i = 0; i < kSoundKinds; ++i) all[static_cast<std::size_t>(i)] = static_cast<SoundKind>(i);
  return all;
}

std::string_view name_of(SoundKind kind) {
  constexpr std::array<std::string_view, kSoundKinds> kNames = {
      "snip",          "clip",        "ratchet",       "ratchet-release", "exchange",     "slip",       "tear",
      "error",         "attention",   "beep",          "cut-tone",        "coag-tone",    "sizzle",     "crackle",
      "crackle-dense", "suction-air", "suction-fluid", "alarm-low",       "alarm-medium", "alarm-high", "room"};
  return kNames[static_cast<std::size_t>(kind)];
}

bool loops(SoundKind kind) {
  return kind >= SoundKind::cut_tone;
}

std::vector<float> synthesise(SoundKind kind, std::uint64_t seed, const SoundParameters& parameters) {
  // Kinds with the same seed draw different numbers.
  detail::Chance chance((seed + 1) * 0x2545f4914f6cdd1dU + static_cast<std::uint64_t>(kind));
  switch (kind) {
    case SoundKind::snip:
      return detail::make_snip(chance);
    case SoundKind::clip:
      return detail::make_clip(chance);
    case SoundKind::ratchet:
      return detail::make_ratchet(chance);
    case SoundKind::ratchet_release:
      return detail::make_ratchet_release(chance);
    case SoundKind::exchange:
      return detail::make_exchange(chance);
    case SoundKind::slip:
      return detail::make_slip(chance);
    case SoundKind::tear:
      return detail::make_tear(chance);
    case SoundKind::error:
      return detail::make_error();
    case SoundKind::attention:
      return detail::make_attention();
    case SoundKind::beep:
      return detail::make_beep(beep_frequency(parameters.saturation));
    // Two steady notes a fifth or so apart, as generators have: told apart without hearing the other.
    case SoundKind::cut_tone:
      return detail::make_generator_tone(660);
    case SoundKind::coag_tone:
      return detail::make_generator_tone(940);
    case SoundKind::sizzle:
      return detail::make_sizzle(chance);
    case SoundKind::crackle:
      return detail::make_crackle(chance, 7);
    case SoundKind::crackle_dense:
      return detail::make_crackle(chance, 36);
    case SoundKind::suction_air:
      return detail::make_suction_air(chance);
    case SoundKind::suction_fluid:
      return detail::make_suction_fluid(chance);
    case SoundKind::alarm_low:
    case SoundKind::alarm_medium:
    case SoundKind::alarm_high:
      return detail::make_alarm(alarm_burst(kind));
    case SoundKind::room:
      return detail::make_room(chance);
  }
  return {};
}

}  // namespace calot
