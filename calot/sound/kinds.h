// Inside this room only: each sound's own maker.
#pragma once
#include "calot/sound/waves.h"

namespace calot::detail {

Samples make_snip(Chance& chance);
Samples make_clip(Chance& chance);
Samples make_ratchet(Chance& chance);
Samples make_ratchet_release(Chance& chance);
Samples make_exchange(Chance& chance);
Samples make_slip(Chance& chance);
Samples make_tear(Chance& chance);
Samples make_sizzle(Chance& chance);
/// @param rate  of bursts [1/s]
Samples make_crackle(Chance& chance, double rate);
Samples make_suction_air(Chance& chance);
Samples make_suction_fluid(Chance& chance);
Samples make_room(Chance& chance);

Samples make_error();
Samples make_attention();
Samples make_beep(double frequency);
Samples make_generator_tone(double frequency);
Samples make_alarm(const AlarmBurst& burst);

}  // namespace calot::detail
