// Finding room for a vessel among others.
#pragma once
#include <vector>

#include "calot/patient/phantom_shapes.h"

namespace calot {

/// What a new vessel has to keep away from.
struct Obstacles {
  struct Tube {
    const Curve* curve;
    double radius;
    double ignored_near_start = 0, ignored_near_end = 0;  ///< the new vessel may touch it so near its own ends [m]
  };
  std::vector<Tube> tubes;
  const SampledField* liver = nullptr;  ///< the vessel's middle stays outside; half of it may press into it
  double liver_ignored_near_start = 0, liver_ignored_near_end = 0;
  const BallChain* gallbladder = nullptr;
  double gallbladder_ignored_near_end = 0;
};

/// The least gap [m] between a tube of this radius and the obstacles; negative where they overlap.
double clearance(const Curve& path, double radius, const Obstacles& obstacles);

/// A chord bowed to one side by `height`, with a slight S across it.
Curve bowed(const Vec3& from, const Vec3& to, const Vec3& side, double height);

}  // namespace calot
