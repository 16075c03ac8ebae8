// Subsurface profiles: where the dipole is off, and slabs that are too narrow.
#include <gtest/gtest.h>

#include "../samples/subsurface/slab.h"
#include "stability.h"

namespace gicube::stability {
namespace {

using samples::Profile;
using samples::Slab;

TEST(StabilityOfSubsurfaceProfiles, TheDipoleIsOffNearTheEntryAndAtLowAlbedo) {
  const auto measured = [](double albedo) {
    Slab slab(open_board("emu:"), 1, albedo, 0, 17);
    return measure_profile(slab.board, slab.medium, {.photons = 60'000, .radius = 12, .rings = 30, .straight = true});
  };
  const Profile dense = measured(0.98), thin = measured(0.5);
  const auto over = [](const Profile& profile, double albedo, double r) {
    return profile.at(r)[0] / samples::dipole(1, albedo, 0, r);
  };
  record("measured_over_dipole_at_0.1", over(dense, 0.98, 0.1));
  record("at_1", over(dense, 0.98, 1));
  record("at_3", over(dense, 0.98, 3));
  record("all", dense.reflected[0] / samples::dipole_reflected(0.98, 0));
  record("all_at_half", thin.reflected[0] / samples::dipole_reflected(0.5, 0));
  EXPECT_GT(over(dense, 0.98, 0.1), 3);
  EXPECT_LT(over(dense, 0.98, 3), 1);
  EXPECT_NEAR(dense.reflected[0], samples::dipole_reflected(0.98, 0), 0.05);
}

// Photons that leave at the sides are lost to the profile.
TEST(StabilityOfSubsurfaceProfiles, ANarrowSlabLosesLightAtItsSidesAndCountsIt) {
  Slab slab(open_board("emu:"), 0.125, 0.999, 0, 49);  // 6 mean free paths wide and deep
  const Profile found = measure_profile(slab.board, slab.medium, {.photons = 20'000, .straight = true});
  record("sideways", found.sideways[0]);
  record("reflected", found.reflected[0]);
  EXPECT_GT(found.sideways[0], 0.1);
  EXPECT_LT(found.reflected[0] + found.sideways[0] + found.transmitted[0], 1);
  EXPECT_GT(found.reflected[0] + found.sideways[0] + found.transmitted[0], 0.95);
}

}  // namespace
}  // namespace gicube::stability
