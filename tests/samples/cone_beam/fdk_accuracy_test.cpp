// The board's reconstruction by its defaults and a double-precision one of the same projections, both judged by the object's means
// in voxels.
#include <gtest/gtest.h>

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

INSTANTIATE_TEST_SUITE_P(FourScansAndSixAtRandom, FdkAccuracy, testing::Range(0, 10));

}  // namespace
}  // namespace gicube::samples
