#include "calot/patient/materials.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/files.h"

namespace {

using namespace calot;

TEST(Materials, AreThePublishedShearModuliTimesThree) {
  EXPECT_DOUBLE_EQ(material_of(Structure::liver).young, 3 * 1.8e3);
  EXPECT_DOUBLE_EQ(material_of(Structure::gallbladder_wall).young, 3 * 85e3);
  EXPECT_DOUBLE_EQ(material_of(Structure::hepatocystic_fat).young, 3 * 750.0);
  EXPECT_DOUBLE_EQ(material_of(Structure::hepatocystic_fat).density, 920);
  for (const Structure duct : {Structure::cystic_duct, Structure::common_bile_duct, Structure::common_hepatic_duct,
                               Structure::aberrant_right_duct})
    EXPECT_DOUBLE_EQ(material_of(duct).young, 3 * 166e3);
  for (const Structure artery :
       {Structure::cystic_artery, Structure::right_hepatic_artery, Structure::second_cystic_artery})
    EXPECT_DOUBLE_EQ(material_of(artery).young, 3 * 210e3);
}

/// The solid gallbladder yields under a jaw as a shell of wall does (within the rounding of E to 12 kPa).
TEST(Materials, SolidGallbladderIsAsStiffAsItsWallAroundBile) {
  const double wall = material_of(Structure::gallbladder_wall).young, nu = 0.45, thickness = 2e-3, radius = 17e-3;
  const double shell = 4 * wall * thickness * thickness / (radius * std::sqrt(3 * (1 - nu * nu)));
  const TissueMaterial solid = material_of(Structure::gallbladder);
  const double punch = 2 * 5e-3 * solid.young / (1 - solid.poisson * solid.poisson);
  EXPECT_NEAR(punch / shell, 1, 0.05);
}

TEST(Materials, EveryOneHasASourceThatTheReferencesHold) {
  const std::string references = test::read_bytes(std::string(CALOT_SOURCE_DIR) + "/docs/references.bib");
  for (const Structure s : all_structures()) {
    const TissueMaterial material = material_of(s);
    EXPECT_GT(material.young, 0) << name_of(s);
    EXPECT_EQ(material.poisson, 0.45) << name_of(s);
    EXPECT_GE(material.density, 900) << name_of(s);
    EXPECT_LE(material.density, 1100) << name_of(s);
    std::size_t keys = 0;
    for (std::size_t at = material.source.find('['); at != std::string::npos; at = material.source.find('[', at + 1)) {
      const std::string key = material.source.substr(at + 1, material.source.find_first_of(",]", at) - at - 1);
      EXPECT_NE(references.find("{" + key + ","), std::string::npos) << key;
      ++keys;
    }
    EXPECT_GE(keys, 1U) << name_of(s);
  }
}

TEST(Materials, LooksAreColoursInRangeAndTellOrgansApart) {
  for (const Structure s : all_structures()) {
    const Appearance look = appearance_of(s);
    for (const double part : {look.red, look.green, look.blue}) {
      EXPECT_GE(part, 0);
      EXPECT_LE(part, 1);
    }
    EXPECT_GT(look.texture_size, 1e-3);
    EXPECT_LT(look.texture_size, 0.1);
    EXPECT_GE(look.blend_sharpness, 1);
  }
  const Appearance liver = appearance_of(Structure::liver), gallbladder = appearance_of(Structure::gallbladder),
                   fat = appearance_of(Structure::hepatocystic_fat), artery = appearance_of(Structure::cystic_artery);
  EXPECT_GT(liver.red, 2 * liver.green);  // red-brown, dark
  EXPECT_LT(liver.red, 0.5);
  EXPECT_GT(gallbladder.green, gallbladder.red);            // bile shines through
  EXPECT_GT(std::min(fat.red, fat.green), 1.5 * fat.blue);  // yellow
  EXPECT_GT(artery.red, 3 * artery.green);
}

}  // namespace
