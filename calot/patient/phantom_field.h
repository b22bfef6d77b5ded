// The operating field of a phantom: its labelled organs as bodies, before they become voxels.
#pragma once
#include <vector>

#include "calot/patient/phantom.h"
#include "calot/patient/phantom_liver.h"

namespace calot {

struct FieldTube {
  Structure structure;
  Centreline line;
  double hounsfield;
  [[nodiscard]] double radius() const { return line.radii.front(); }
};

struct OperatingField {
  PhantomFacts facts;
  Vec3 hub;  ///< where hepatic and cystic duct usually join: the origin but in the variant of a low insertion
  Centreline bile_duct;      ///< common hepatic and common bile duct in one, downwards
  std::size_t junction = 0;  ///< point of the bile duct where the cystic duct joins: the origin
  Vec3 junction_direction;   ///< of the bile duct there, downwards
  Vec3 mouth;                ///< of the cystic duct, in the bile duct's wall: the label changes at its height
  BallChain lumen;           ///< of the gallbladder; with its wall, where that is no region of its own
  BallChain outside;         ///< of the gallbladder's wall
  double bed_thickness = 0;
  Liver liver;
  std::vector<FieldTube> tubes;  ///< all but the bile duct, in the order of painting
  SampledField fat;              ///< hepatocystic fat, before organs are cut out of it

  [[nodiscard]] const FieldTube& tube(Structure s) const;
  /// Lines of all tubes along the flow, the bile duct divided at the junction.
  [[nodiscard]] std::vector<Centreline> lines() const;
};

/// Draws one. The biliary tree of the usual variant is that of make_biliary_tree for the same seed. Throws FailedError
/// where a seed leaves no room for a vessel.
OperatingField draw_operating_field(std::uint64_t seed, PhantomVariant variant);

// In their order, each using what those before it drew:
void draw_field_ducts(std::uint64_t seed, PhantomVariant variant, Random& random, OperatingField& field);
void draw_field_vessels(PhantomVariant variant, Random& random, OperatingField& field);
SampledField draw_hepatocystic_fat(Random& random, const OperatingField& field);

}  // namespace calot
