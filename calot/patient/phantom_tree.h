// The biliary tree of a phantom, drawn from the published ranges (docs/patient.md).
#pragma once
#include "calot/patient/phantom.h"
#include "calot/patient/random.h"
#include "calot/patient/sweep.h"

namespace calot {

/// Radius of the gallbladder's neck, where the cystic duct begins [m].
inline constexpr double gallbladder_neck_radius = 2.6e-3;

/// A direction near `v`, each component moved by up to ±spread, of length 1.
Vec3 vary(Random& random, const Vec3& v, double spread);
double limited_normal(Random& random, double mean, double deviation, double low, double high);

/// Common hepatic and common bile duct in one: from the hilum down through the junction (the origin), behind the
/// duodenum and to the right again, to the papilla. Fills the facts of both.
Centreline draw_bile_duct(Random& random, PhantomFacts& facts);

/// Length and diameter, into the facts.
void draw_cystic_duct_sizes(Random& random, PhantomFacts& facts);
/// The cystic duct winds from the neck backwards, down and to the left into the side of the bile duct (the origin). Its
/// shape is drawn first; then it is scaled so that the part between the two walls has the length of the facts.
Centreline draw_cystic_duct(Random& random, double neck_radius, const Centreline& bile, const PhantomFacts& facts);
/// The part of the line outside the neck's ball (around its first point) and the bile duct: what a surgeon calls the
/// cystic duct.
double visible_length(const Curve& line, double neck_radius, const Centreline& bile);

/// The gallbladder from neck to fundus, of a volume and a length drawn from the published ranges; its width follows and
/// must lie in its own.
BallChain draw_gallbladder(Random& random, const Vec3& neck, double neck_radius, PhantomFacts& facts);

}  // namespace calot
