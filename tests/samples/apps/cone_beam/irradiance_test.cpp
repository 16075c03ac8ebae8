// Backprojection into the paper's 11-bit words, by two passes.
#include "cone_beam/fdk.h"

#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

const ConeGeometry& scan() {
  static const ConeGeometry geometry = small_scan(32, 40);
  return geometry;
}
const Projections& views() {
  static const Projections projections = project(high_contrast_shepp_logan(42), scan());
  return projections;
}
Reconstruction made(const FdkSettings& settings, const std::string& options = "") {
  Board board = open_board(options);
  return reconstruct_fdk(board, scan(), views(), settings);
}
double off(const Reconstruction& one, const Reconstruction& other) {
  return compare(scan().volume, one.values, other.values, {42, 20}).rmse;
}

TEST(IrradianceWords, MakeWhatSumsMakeUpToTheirRounding) {
  const Reconstruction sums = made({}), words = made({.accumulator = Accumulator::kIrradiance, .read_every = 1});
  EXPECT_EQ(words.clipped, 0);
  EXPECT_LT(off(words, sums), 0.1);
  EXPECT_GT(off(words, sums), 0);
  EXPECT_GT(words.board_time, sums.board_time);
  // Each ray goes in one of the passes.
  EXPECT_NEAR(static_cast<double>(words.rays), static_cast<double>(sums.rays), 0.01 * static_cast<double>(sums.rays));
}

TEST(IrradianceWords, TheRarerTheyAreReadTheCoarserTheyAre) {
  const Reconstruction sums = made({});
  double last = 0;
  Picoseconds time = ~Picoseconds{0};
  for (const int every : {1, 4, 20}) {
    const Reconstruction words = made({.accumulator = Accumulator::kIrradiance, .read_every = every});
    EXPECT_GT(off(words, sums), 1.5 * last) << every;
    EXPECT_LT(words.board_time, time) << every;
    last = off(words, sums);
    time = words.board_time;
  }
}

TEST(IrradianceWords, TheWideOnesAreAsGoodAsSums) {
  const Reconstruction sums = made({});
  const std::string wide = "&set=asic.datapath=wide";
  EXPECT_LT(off(made({.accumulator = Accumulator::kIrradiance, .read_every = 40}, wide), sums), 1e-3);
  EXPECT_GT(off(made({.accumulator = Accumulator::kIrradiance, .read_every = 40, .bits = 8}, wide), sums), 0.1);
}

TEST(IrradianceWords, WhatIsClippedIsReported) {
  const Reconstruction words = made({.accumulator = Accumulator::kIrradiance, .read_every = 8, .headroom = 0.02});
  EXPECT_GT(words.clipped, 0.001);
  EXPECT_LT(words.clipped, 1);
}

TEST(IrradianceWords, SettingsThatCantBeAreNamed) {
  EXPECT_THROWS(BadArgument, "read_every", made({.read_every = 0}));
  EXPECT_THROWS(BadArgument, "bits", made({.bits = 3}));
  EXPECT_THROWS(BadArgument, "headroom", made({.headroom = 0}));
}

}  // namespace
}  // namespace gicube::samples
