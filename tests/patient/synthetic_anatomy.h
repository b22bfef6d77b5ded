// An abdomen of simple shapes, whose landmarks can be worked out by hand.
#pragma once
#include "calot/patient/completion.h"

namespace calot::test {

struct SyntheticOptions {
  double voxel = 1.5e-3;
  bool whole_body = true;      ///< false: the field ends 20 mm around the organs
  bool flipped = false;        ///< voxel axes to the left, the back and the head, as most scanners have them
  double duct_length = 0.028;  ///< of the cystic duct, from the middle of the bile duct to the gallbladder [m]
  double more_fat = 0;         ///< under the skin [m]
  bool with_artery = true;
  bool reversed_lines = false;  ///< drawn from the other end
};

/// Junction of the ducts at the origin; the body's midline at x = −35 mm, skin at the front at y = 105 mm there; skin
/// and fat of 17 mm, muscle of 10 mm, a vertebral column behind.
CompletedAnatomy synthetic_anatomy(const SyntheticOptions& options = {});

inline constexpr double synthetic_midline = -0.035, synthetic_skin = 0.105, synthetic_wall = 0.027;

}  // namespace calot::test
