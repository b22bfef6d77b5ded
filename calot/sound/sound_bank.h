// Inside this room only: every sound, synthesised once, several variants of those played once.
#pragma once
#include <array>
#include <vector>

#include "calot/sound/sounds.h"

namespace calot::detail {

inline constexpr int kVariants = 4;  ///< of noises played once, so that two snips in a row differ
inline constexpr int kLowestBeep = 50;

struct SoundBank {
  using Take = std::vector<std::int16_t>;
  explicit SoundBank(std::uint64_t seed);
  std::array<std::vector<Take>, kSoundKinds> takes;  ///< of each kind; of the beep for 50, 51 … 100 %
};

}  // namespace calot::detail
