// The board's reconstruction by its defaults and a double-precision one of the same projections, both judged by the object's means
// in voxels.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "cone_beam/fdk.h"
#include "open_board.h"
#include "reference/fdk.h"
#include "reference/fdk_phantoms.h"

namespace gicube::samples {
namespace {

using reference::FdkScan;

FdkScan scan_of(int i) {
  return i < 4 ? reference::fdk_scans(40)[static_cast<std::size_t>(i)]
               : reference::random_fdk_scan(32, static_cast<unsigned>(i));
}

class FdkAccuracy : public testing::TestWithParam<int> {
 protected:
  // Of all voxels, over that of the reference.
  double rmse_ratio(const FdkSettings& settings) {
    Board board = open_board();
    const Reconstruction made = reconstruct_fdk(board, scan_.geometry, views_, settings);
    EXPECT_EQ(made.overflowed, 0u);
    return rmse(made.values) / reference_;
  }

 private:
  template <typename Values>
  double rmse(const Values& values) const {
    constexpr double kAll = std::numeric_limits<double>::infinity();
    return reference::difference(scan_.geometry.volume, values, truth_, kAll, kAll).rmse;
  }

  const FdkScan scan_ = scan_of(GetParam());
  const Projections views_ = project(scan_);
  const std::vector<double> truth_ = mean_in_voxels(scan_);
  const double reference_ = rmse(reference::reconstruct(scan_.geometry, views_));
};

TEST_P(FdkAccuracy, RmseIsAtMostATwentiethMoreThanInDoublePrecision) {
  EXPECT_LE(rmse_ratio({}), 1.05);
  EXPECT_LE(rmse_ratio({.normalise = false}), 1.05);
}

// Pixels of any width and height, in voxels: of six solids and of one ball, in all of the volume and around its middle.
TEST(FdkPixels, MayHaveAnyWidthAndHeightAndAreAsGoodAsInDoublePrecision) {
  for (const std::array<double, 2> pixel :
       {std::array{0.69, 0.69}, {0.8, 0.5}, {0.9, 0.65}, {1.01, 0.8}, {0.8, 1.01}}) {
    for (const bool ball : {false, true}) {
      FdkScan scan = reference::random_fdk_scan(32, 1, pixel);
      if (ball) scan.object = {{.value = 1, .half = {31, 30, 29}, .centre = {2, -3, 1}}};
      const Projections views = project(scan);
      const std::vector<double> truth = mean_in_voxels(scan);
      const std::vector<double> reference = reference::reconstruct(scan.geometry, views);
      Board board = open_board();
      const Reconstruction made = reconstruct_fdk(board, scan.geometry, views);
      for (const double within : {27.0, 1e9}) {
        const auto rmse = [&](const auto& values) {
          return reference::difference(scan.geometry.volume, values, truth, within, within).rmse;
        };
        // Two rays of pixels just above a voxel's width leave up to 1.08 in volumes of few voxels.
        const double bound = pixel[0] > 1 ? 1.08 : 1.05;
        EXPECT_LE(rmse(made.values), bound * rmse(reference)) << scan.name << (ball ? ", a ball, " : ", ") << within;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FourScansAndSixAtRandom, FdkAccuracy, testing::Range(0, 10));

}  // namespace
}  // namespace gicube::samples
