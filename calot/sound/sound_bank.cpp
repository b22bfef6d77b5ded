#include "calot/sound/sound_bank.h"

#include "calot/sound/wav.h"

namespace calot::detail {

SoundBank::SoundBank(std::uint64_t seed) {
  for (const SoundKind kind : all_sounds()) {
    std::vector<Take>& of_kind = takes[static_cast<std::size_t>(kind)];
    if (kind == SoundKind::beep) {
      for (int s = kLowestBeep; s <= 100; ++s) {
        of_kind.push_back(to_16_bit(synthesise(kind, seed, {.saturation = static_cast<double>(s)})));
      }
      continue;
    }
    const bool tone = kind == SoundKind::error || kind == SoundKind::attention;
    const int count = loops(kind) || tone ? 1 : kVariants;
    for (int i = 0; i < count; ++i) {
      of_kind.push_back(to_16_bit(synthesise(kind, seed * kVariants + static_cast<std::uint64_t>(i))));
    }
  }
}

}  // namespace calot::detail
