// The liver of a phantom, built around the gallbladder that hangs on it.
#pragma once
#include "calot/patient/phantom.h"
#include "calot/patient/phantom_shapes.h"
#include "calot/patient/random.h"

namespace calot {

/// What the liver has to fit.
struct LiverAnchors {
  Vec3 hub;  ///< where hepatic and cystic duct usually join; the body's plan is laid out around it [m]
  const BallChain* gallbladder;  ///< outer side of its wall, neck first
  double bed_thickness;          ///< of the layer between the two [m]
  Vec3 hilum;                    ///< where the common hepatic duct enters [m]
};

/// A dome (right and left lobe), cut below by the visceral surface, a sheet that follows the gallbladder.
struct LiverForm {
  Superellipsoid right, left, caudate;
  Vec3 sheet_point, down, across;  ///< a point of the visceral surface, its normal, and the direction right across it
  double drop_right = 0, drop_left = 0;  ///< how far the lobes hang down beside the gallbladder [m]
  double bend = 0, bend_from = 0;  ///< how it descends to the hilum [1/m], and how far behind the point that begins
  Vec3 hilum;
  double hilum_shift = 0;  ///< what is still missing there [m]
  Curve fissure, cava;     ///< of the round ligament; the vena cava
  /// The liver without the gallbladder's fossa.
  [[nodiscard]] double distance(const Vec3& p) const;
  /// The dome alone.
  [[nodiscard]] double dome(const Vec3& p) const;
};

struct Liver {
  LiverForm form;
  SampledField field;  ///< form.distance
};

/// Draws a volume from the published distribution and finds the shape that has it, within the published extents, the
/// gallbladder's fundus at its lower edge. Fills the facts of the liver. Throws FailedError.
Liver draw_liver(Random& random, const LiverAnchors& anchors, PhantomFacts& facts);

}  // namespace calot
