// What there is to hear at one moment: filled by whoever knows the operation, played by SoundPlayer and SoundRecorder.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "calot/sound/sounds.h"

namespace calot {

/// Where a sound comes from, as the laparoscope sees it [m]: x right, y up, z towards the eye (what is seen has z < 0).
using SoundPosition = Eigen::Vector3d;

/// A sound played once.
struct SoundCue {
  SoundKind kind = SoundKind::attention;             ///< none that loops
  SoundPosition position = SoundPosition(0, 0, -1);  ///< error, attention and beep come from the front wherever this is
  double gain = 1;                                   ///< 0 … 2
};

enum class CauteryMode : std::uint8_t { off, cut, coagulate };
enum class AlarmPriority : std::uint8_t { none, low, medium, high };

/// What goes on while it does. Numbers that aren't finite count as 0.
struct SoundScene {
  CauteryMode cautery = CauteryMode::off;  ///< the pedal is down: the generator's tone
  double cautery_power = 0;                ///< that reaches tissue [W]: sizzle and crackle
  SoundPosition cautery_position = SoundPosition(0, 0, -0.1);
  bool suction = false;
  double suction_flow = 0;  ///< of fluid through the tube [m³/s]; 0 is gas alone
  SoundPosition suction_position = SoundPosition(0, 0, -0.1);
  double heart_rate = 0;   ///< [1/min], up to 300; 0 = no monitor
  double saturation = 98;  ///< of the blood with oxygen [%]
  AlarmPriority alarm = AlarmPriority::none;
  bool room = true;  ///< the room's hum
};

/// Gains of what goes on, each 0 … 1: how a scene is mixed.
struct SoundMix {
  double sizzle = 0, crackle = 0, crackle_dense = 0, suction_air = 0, suction_fluid = 0;
};
/// Loudness follows the power: sound intensity as the steam's, so the amplitude as its root; all of it at 40 W.
/// Crackling comes more often from 5 W on, most at 25 W. Fluid drowns the hiss; all gurgle at 10 ml/s.
SoundMix mix_of(const SoundScene& scene);

}  // namespace calot
