#include "form_factors/exchange/box_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "form_factors/program/options.h"
#include "scene/program/board_run.h"

namespace gicube::samples {
namespace {

// Published values of these pairs, to their last digit; docs/guide/form_factors.md has the larger table.
TEST(ClosedForms, AreThoseOfTheTable) {
  EXPECT_NEAR(parallel_squares(0), 0.199825, 5e-7);
  EXPECT_NEAR(perpendicular_squares(), 0.200044, 5e-7);
  EXPECT_NEAR(parallel_squares(0.1), 0.1789, 1e-4);
  EXPECT_NEAR(parallel_squares(1), 0.0662, 5e-5);
  EXPECT_NEAR(parallel_squares(3), 0.0074, 5e-5);
  EXPECT_NEAR(parallel_squares(1e-12), parallel_squares(0), 1e-8);  // quadrature and closed form
  EXPECT_NEAR(mean_inverse_square(2), 0.260, 5e-4);
  EXPECT_NEAR(mean_inverse_square(50) * 2500, 1, 1e-3);
}

TEST(ErrorCurves, FallFasterThanThoseOfRandomPointsAndAreSmall) {
  setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  Board board = open_board({});
  const auto curves = closed_form_curves(board, 16'384);
  ASSERT_EQ(curves.size(), 5u);
  for (const ErrorCurve& curve : curves) {
    ASSERT_EQ(curve.rays.size(), curve.errors.size());
    EXPECT_GT(curve.rays.back(), 10'000u) << curve.name;
    EXPECT_LT(curve.errors.back(), 0.001) << curve.name;
    // Of a near pair in a clear volume all but the last digits is known without rays.
    if (curve.name == "common edge") continue;
    EXPECT_LT(curve.slope, -0.5) << curve.name;
  }
}

}  // namespace
}  // namespace gicube::samples
