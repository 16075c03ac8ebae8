// The board's reconstruction by its defaults and a double-precision one of the same projections, both judged by the
// object's means in voxels.
#include "cone_beam/fdk.h"
#include "open_board.h"
#include "reference/fdk.h"
#include "reference/fdk_phantoms.h"
#include "test.h"

namespace gicube::samples {
namespace {

using reference::FdkScan;

FdkScan scan_of(int i) {
  return i < 4 ? reference::fdk_scans(40)[static_cast<std::size_t>(i)]
               : reference::random_fdk_scan(32, static_cast<unsigned>(i));
}

class FdkAccuracy : public testing::TestWithParam<int> {
 protected:
  // Over all voxels, divided by that of the reference.
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

// Pixels of any width and height, in voxels: of six solids, of one ball and of a thin shell, in all of the volume and
// around its middle.
TEST(FdkPixels, MayHaveAnyWidthAndHeightAndAreAsGoodAsInDoublePrecision) {
  for (const std::array<double, 2> pixel :
       {std::array{0.69, 0.69}, {0.75, 0.75}, {0.8, 0.5}, {0.9, 0.65}, {1.01, 0.5}, {1.01, 0.8}, {0.8, 1.01}}) {
    FdkScan scan = reference::random_fdk_scan(32, 1, pixel);
    const std::vector<reference::Solid> ball{{.value = 1, .half = {31, 30, 29}, .centre = {2, -3, 1}}};
    for (const auto& [name, object] :
         {std::pair{"six solids", scan.object}, {"a ball", ball}, {"a shell", reference::fdk_scans(32)[3].object}}) {
      scan.object = object;
      const Projections views = project(scan);
      const std::vector<double> truth = mean_in_voxels(scan);
      const std::vector<double> reference = reference::reconstruct(scan.geometry, views);
      Board board = open_board();
      const Reconstruction made = reconstruct_fdk(board, scan.geometry, views);
      for (const double within : {27.0, 1e9}) {
        const auto rmse = [&](const auto& values) {
          return reference::difference(scan.geometry.volume, values, truth, within, within).rmse;
        };
        const double ratio = rmse(made.values) / rmse(reference);
        EXPECT_LE(ratio, 1.05) << scan.name << ", " << name << ", " << within;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FourScansAndSixAtRandom, FdkAccuracy, testing::Range(0, 10));

}  // namespace
}  // namespace gicube::samples
