// Measured profiles against closed forms, tables, random walks and the dipole.
#include "subsurface/profile.h"

#include <gtest/gtest.h>

#include "../../driver/board/test_board.h"
#include "reference/slab_table.h"
#include "slab.h"

namespace gicube::samples {
namespace {

// 48 mean free paths wide, 16 deep.
Profile of_half_space(double albedo, std::uint64_t photons) {
  Slab slab(reference::open_board(), 1, albedo, 0, 17);
  return measure_profile(slab.board, slab.medium, {.photons = photons, .radius = 12, .rings = 30, .straight = true});
}

TEST(Profile, ReflectsWhatTheHFunctionSaysOfAHalfSpace) {
  const Profile found = of_half_space(0.9, 60'000);
  for (const auto& [c, albedo] : {std::pair{std::size_t{0}, 0.9}, {std::size_t{1}, 0.81}, {std::size_t{2}, 0.45}}) {
    EXPECT_NEAR(found.reflected[c], half_space_albedo(albedo), 3 * found.reflected_error[c] + 1e-4) << c;
    EXPECT_LT(found.reflected_error[c], 0.008 * found.reflected[c]) << c;
  }
  EXPECT_LT(found.transmitted[0], 1e-3);
  EXPECT_LT(found.sideways[0], 1e-3);
}

TEST(Profile, HasTheRadiiOfRandomWalks) {
  const Profile found = of_half_space(0.9, 60'000);
  const std::vector<double> radii{found.rings[5].outer, found.rings[10].outer, found.rings[18].outer,
                                  found.rings[29].outer};
  const std::vector<double> truth = half_space_within(0.9, radii, 400'000);
  for (std::size_t k = 0; k < radii.size(); ++k) {
    // Both are shares of photons.
    const double error = std::sqrt(truth[k] * (1 - truth[k]) * (1.0 / 60'000 + 1.0 / 400'000));
    EXPECT_NEAR(found.within(radii[k])[0], truth[k], 3 * error) << radii[k];
  }
}

TEST(Profile, OfThinSlabsReflectsAndTransmitsWhatTheTableSays) {
  for (const reference::SlabRow& row : reference::kSlabTable) {
    if (row.optical_thickness > 4 || row.optical_thickness < 0.5) continue;
    Slab slab(reference::open_board(), row.optical_thickness / 4, row.albedo, 0, 5);
    const Profile found = measure_profile(slab.board, slab.medium, {.photons = 30'000, .straight = true});
    const auto error = [](double share) { return std::sqrt(share * (1 - share) / 30'000); };
    EXPECT_NEAR(found.reflected[0], row.reflected, 3 * error(row.reflected) + 1e-3);
    EXPECT_NEAR(found.transmitted[0], row.transmitted, 3 * error(row.transmitted) + found.sideways[0] + 1e-3);
  }
}

// Light straight through is exp(-optical thickness); with what is scattered once more it is the table's. Runs of any number of photons
// scatter by what they state, which is a share's error.
TEST(Profile, TransmitsWithTheErrorThatItStates) {
  for (const double thickness : {1.0, 4.0}) {
    Slab slab(reference::open_board(), thickness / 4, 0, 0, 5);
    const double truth = std::exp(-thickness);
    constexpr int kRuns = 12;
    for (const std::uint64_t photons : {std::uint64_t{1'000}, std::uint64_t{3'333}, std::uint64_t{40'001}}) {
      double sum = 0, squares = 0;
      for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
        const Profile found =
            measure_profile(slab.board, slab.medium, {.photons = photons, .straight = true, .seed = seed});
        const double stated = std::sqrt(truth * (1 - truth) / static_cast<double>(photons));
        EXPECT_NEAR(found.transmitted_error[0], stated, 0.2 * stated);
        const double off = (found.transmitted[0] - truth) / stated;
        sum += off, squares += off * off;
        EXPECT_EQ(found.reflected[0], 0);
      }
      EXPECT_NEAR(sum / kRuns, 0, 3 / std::sqrt(kRuns)) << thickness << ", " << photons;
      EXPECT_LT(std::sqrt(squares / kRuns), 1.5) << thickness << ", " << photons;
    }
  }
}

// The dipole is of diffusion theory: far from the entry its fall is that of the medium, near it and in all it is off.
TEST(Dipole, IsTheIntegralOfItsProfileAndNearTheMeasuredOneFarAway) {
  double sum = 0;
  constexpr int kSteps = 200'000;
  for (int i = 0; i < kSteps; ++i) {
    const double r = 200.0 * (i + 0.5) / kSteps;
    sum += dipole(1, 0.9, 0, r) * 2 * std::numbers::pi * r * 200 / kSteps;
  }
  EXPECT_NEAR(sum, dipole_reflected(0.9, 0), 2e-3);  // its tail
  const Profile found = of_half_space(0.98, 100'000);
  for (const double r : {3.0, 5.0})
    EXPECT_NEAR(found.at(r)[0], dipole(1, 0.98, 0, r), 0.25 * dipole(1, 0.98, 0, r)) << r;
  EXPECT_GT(found.at(0.1)[0], 1.5 * dipole(1, 0.98, 0, 0.1));
}

TEST(Profile, IsLinearBetweenRingsAndAddsUp) {
  Profile profile;
  profile.rings = {{0, 1, {0.3, 0, 0}, {}}, {1, 2, {0.3, 0.1, 0}, {}}};
  EXPECT_NEAR(profile.at(0.2)[0], 0.3 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(profile.at(1)[0], (0.3 + 0.1) / 2 / std::numbers::pi, 1e-12);
  EXPECT_EQ(profile.at(2)[0], 0);
  EXPECT_NEAR(profile.within(1)[0], 0.3, 1e-12);
  EXPECT_NEAR(profile.within(9)[0], 0.6, 1e-12);
  EXPECT_NEAR(profile.within(std::sqrt(2.5))[0], 0.45, 1e-12);
}

}  // namespace
}  // namespace gicube::samples
