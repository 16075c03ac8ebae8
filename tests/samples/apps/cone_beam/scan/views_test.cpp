#include "cone_beam/scan/scan.h"

#include "test.h"

namespace gicube::samples {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<double> degrees(std::vector<double> angles) {
  for (double& angle : angles) angle *= kDegree;
  return angles;
}

TEST(SortedViews, KeepAnAscendingTurn) {
  const SortedViews views = sorted_views(degrees({10, 100, 190, 280}));
  EXPECT_THAT(views.angles, Pointwise(DoubleNear(1e-12), degrees({10, 100, 190, 280})));
  EXPECT_THAT(views.places, ElementsAre(ElementsAre(0), ElementsAre(1), ElementsAre(2), ElementsAre(3)));
  EXPECT_EQ(views.repeated(), 0u);
}

TEST(SortedViews, TurnAClockwiseScanRound) {
  const SortedViews views = sorted_views(degrees({180, 90, 0, -90}));
  EXPECT_THAT(views.angles, Pointwise(DoubleNear(1e-12), degrees({180, 270, 360, 450})));
  EXPECT_THAT(views.places, ElementsAre(ElementsAre(0), ElementsAre(3), ElementsAre(2), ElementsAre(1)));
}

TEST(SortedViews, TakeAWholeTurnLaterForTheSameAngle) {
  const SortedViews views = sorted_views(degrees({0, 120, 240, 360, 480}));
  EXPECT_THAT(views.angles, Pointwise(DoubleNear(1e-12), degrees({0, 120, 240})));
  EXPECT_THAT(views.places, ElementsAre(ElementsAre(0, 3), ElementsAre(1, 4), ElementsAre(2)));
  EXPECT_EQ(views.repeated(), 2u);
}

TEST(SortedViews, TakeAnAngleRoundedBelowATurnForTheSame) {
  const SortedViews views = sorted_views({0, 2, 4, 2 * std::numbers::pi - 1e-9});
  EXPECT_EQ(views.angles.size(), 3u);
  EXPECT_THAT(views.places[0], ElementsAre(0, 3));
}

TEST(SortedViews, BeginAShortScanBehindItsGapEvenAcrossZero) {
  const SortedViews views = sorted_views(degrees({20, 50, 80, 110, 140, 290, 320, 350}));
  EXPECT_THAT(views.angles, Pointwise(DoubleNear(1e-12), degrees({290, 320, 350, 380, 410, 440, 470, 500})));
  EXPECT_THAT(views.places.front(), ElementsAre(5));
}

TEST(SortedViews, StayWithinATurnInAnyOrder) {
  const SortedViews views = sorted_views(degrees({300, 20, 140, 260, 60, 100, 180, 220, 340}));
  ASSERT_EQ(views.angles.size(), 9u);
  for (std::size_t i = 1; i < 9; ++i) EXPECT_GT(views.angles[i], views.angles[i - 1]);
  EXPECT_LT(views.angles.back() - views.angles.front(), 360 * kDegree);
}

}  // namespace
}  // namespace gicube::samples
