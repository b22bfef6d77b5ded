#include "calot/sim/tissue_properties.h"

#include <gtest/gtest.h>

#include <limits>

#include "calot/base/error.h"
#include "tests/support/meshes.h"

namespace calot {
namespace {

TEST(TissueProperties, EveryKnownRegionIsInRangeAndAnUnknownOneIsSoftTissue) {
  for (const char* name : {"liver", "gallbladder", "cystic duct", "common bile duct", "common hepatic duct",
                           "cystic artery", "right hepatic artery", "hepatocystic fat", "gallbladder bed",
                           "second cystic artery", "aberrant right hepatic duct", "gallbladder wall", "spleen", ""})
    EXPECT_NO_THROW(check(tissue_properties(name), name)) << name;
  EXPECT_EQ(tissue_properties("spleen").vessel, VesselKind::none);
}

TEST(TissueProperties, VesselsCarryWhatTheyShould) {
  EXPECT_EQ(fluid_of(tissue_properties("cystic artery").vessel), Fluid::blood);
  EXPECT_EQ(fluid_of(tissue_properties("liver").vessel), Fluid::blood);
  EXPECT_EQ(fluid_of(tissue_properties("cystic duct").vessel), Fluid::bile);
  EXPECT_EQ(fluid_of(tissue_properties("gallbladder wall").vessel), Fluid::bile);
  EXPECT_GT(tissue_properties("cystic artery").pressure, 5 * tissue_properties("cystic duct").pressure);
}

TEST(TissueProperties, OfAMeshAreByItsRegionsNames) {
  const auto all = tissue_properties(test::biliary_mesh());
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all.at(2).vessel, VesselKind::gallbladder);
  EXPECT_EQ(all.at(3).vessel, VesselKind::bile_duct);
}

TEST(TissueProperties, RefusesWhatIsOutOfRangeByName) {
  TissueProperties p;
  p.conductivity = std::numeric_limits<double>::quiet_NaN();
  try {
    check(p, "liver");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "tissue \"liver\": conductivity is out of range; give W/(m K) above 0");
  }
  p = {};
  p.ultimate_stretch = 1;
  EXPECT_THROW(check(p, "x"), InputError);
  p = tissue_properties("cystic duct");
  p.outer_radius = 0.5 * p.inner_radius;
  EXPECT_THROW(check(p, "x"), InputError);
}

}  // namespace
}  // namespace calot
