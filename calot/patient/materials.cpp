#include "calot/patient/materials.h"

namespace calot {
namespace {

// Soft tissue hardly changes its volume (ν → 0.5), but linear tetrahedra lock there; at 0.45 a solid is still 10 times
// stiffer against compression than against shear (K/G = 9.7), and the elements bend as they should.
constexpr double nu = 0.45;
const std::string solid = "; nu 0.45 stands for nearly incompressible, as linear tetrahedra lock near 0.5";

/// E = 3 G, that of an incompressible material.
TissueMaterial from_shear_modulus(double shear, double density, const std::string& source) {
  return {3 * shear, nu, density, source + solid};
}

TissueMaterial duct() {
  return from_shear_modulus(166e3, 1060,
                            "E = 3 G, G 166 +- 67 kPa of bile duct [Mancia2019, table 1]; the wall's value for the "
                            "whole tube, whose lumen isn't meshed");
}

TissueMaterial artery() {
  return from_shear_modulus(210e3, 1050,
                            "E = 3 G, G 210 +- 47 kPa of hepatic artery [Mancia2019, table 1]; the wall's value for "
                            "the whole tube, whose lumen isn't meshed");
}

}  // namespace

TissueMaterial material_of(Structure s) {
  switch (s) {
    case Structure::gallbladder:
      // k of a shell pushed at a point, 4 E t² / (R √(3(1 − ν²))), with the wall's E 255 kPa, t 2 mm, R 17 mm: 155 N/m.
      // k of a solid under a round punch, 2 a E / (1 − ν²), a 5 mm (half a jaw): 155 N/m at E 12.4 kPa.
      return {12e3, nu, 1020,
              "effective value of a solid that stands for a bile-filled sac: yields under a 10 mm jaw as a spherical "
              "shell [Reissner1946] of wall G 85 kPa [Mancia2019, table 1], 2 mm thick, radius 17 mm; the density is "
              "that of bile and wall together" +
                  solid};
    case Structure::gallbladder_wall:
      return from_shear_modulus(85e3, 1060,
                                "E = 3 G, G 85 +- 8 kPa of gallbladder wall [Mancia2019, table 1]; an inflamed wall "
                                "is assumed as stiff as a sound one, only thicker");
    case Structure::cystic_duct:
    case Structure::common_bile_duct:
    case Structure::common_hepatic_duct:
    case Structure::aberrant_right_duct:
      return duct();
    case Structure::cystic_artery:
    case Structure::right_hepatic_artery:
    case Structure::second_cystic_artery:
      return artery();
    case Structure::hepatocystic_fat:
      return from_shear_modulus(
          750, 920, "E = 3 G, G 0.75 kPa of human fat in vivo, undeformed [Hatt2023]; density of fat [Duck1990]");
    case Structure::gallbladder_bed:
      return from_shear_modulus(1.8e3, 1000,
                                "no measurement of the cystic plate was found: assumed as soft as the liver it lies on "
                                "[Mancia2019, table 1]");
    case Structure::liver:
    case Structure::none:
      break;
  }
  return from_shear_modulus(1.8e3, 1060, "E = 3 G, G 1.8 +- 0.4 kPa of liver [Mancia2019, table 1]");
}

Appearance appearance_of(Structure s) {
  switch (s) {
    case Structure::gallbladder:
      return {0.47, 0.57, 0.50, 0.015, 4};  // bile shines through: grey-green
    case Structure::gallbladder_wall:
      return {0.68, 0.42, 0.38, 0.012, 4};  // inflamed: reddened
    case Structure::cystic_duct:
    case Structure::common_bile_duct:
    case Structure::common_hepatic_duct:
    case Structure::aberrant_right_duct:
      return {0.66, 0.63, 0.42, 0.006, 6};  // greenish tan
    case Structure::cystic_artery:
    case Structure::right_hepatic_artery:
    case Structure::second_cystic_artery:
      return {0.72, 0.18, 0.16, 0.005, 6};
    case Structure::hepatocystic_fat:
      return {0.91, 0.78, 0.42, 0.010, 4};
    case Structure::gallbladder_bed:
      return {0.80, 0.68, 0.58, 0.010, 4};  // pale areolar tissue
    case Structure::liver:
    case Structure::none:
      break;
  }
  return {0.40, 0.15, 0.12, 0.030, 4};  // dark red-brown
}

}  // namespace calot
