#include "cone_beam/plan/plan.h"

#include "../open_board.h"
#include "../small_scan.h"
#include "cone_beam/phantom/phantom.h"
#include "test.h"

namespace gicube::samples {
namespace {

Phantom head() { return high_contrast_shepp_logan(38); }

TEST(FdkPlan, TakesMoreDepositsForLessError) {
  Board board = open_board("&fidelity=functional");
  const ConeGeometry geometry = small_scan(32, 48);
  const Projections projections = project(head(), geometry);
  double last = 0;
  for (const double error : {0.5, 0.2, 0.03}) {
    const FdkPlan plan = plan_fdk(board, geometry, projections, {}, {error, 0});
    EXPECT_TRUE(plan.kept) << error;
    EXPECT_LE(plan.chosen.error_bound, error);
    EXPECT_GT(plan.chosen.deposits, last);
    EXPECT_LE(plan.chosen.deposits, plan.finest.deposits);
    last = plan.chosen.deposits;
  }
}

TEST(FdkPlan, ChoosesTheCheapestOfAllThatItFoundToKeepTheTarget) {
  Board board = open_board("&fidelity=functional");
  std::mt19937 random(6);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int cheaper = 0;
  for (int i = 0; i < 8; ++i) {
    const ConeGeometry geometry = small_scan(i % 2 == 0 ? 20 : 26, i % 3 == 0 ? 24 : 48);
    const Projections projections = project(high_contrast_shepp_logan(within(25, 40)), geometry);
    const double error = std::exp(within(std::log(0.02), std::log(0.6)));
    SCOPED_TRACE(testing::Message() << "request " << i << ", target " << error);
    const FdkPlan plan = plan_fdk(board, geometry, projections, {}, {error, 0});
    EXPECT_TRUE(plan.kept);
    EXPECT_LE(plan.chosen.error_bound, error);
    cheaper += plan.chosen.deposits < plan.finest.deposits;
    for (const FdkPlanPoint& point : plan.points) {
      if (point.error_bound > error) continue;
      EXPECT_GE(point.deposits, plan.chosen.deposits)
          << "every " << point.every << ", rays " << point.rays << ", step " << point.step;
    }
  }
  EXPECT_GT(cheaper, 4);
}

TEST(FdkPlan, TheFinestSettingIsWithoutError) {
  Board board = open_board("&fidelity=functional");
  const ConeGeometry geometry = small_scan(24, 24);
  const FdkPlan plan = plan_fdk(board, geometry, project(head(), geometry), {}, {1e-9, 0});
  EXPECT_TRUE(plan.kept);
  EXPECT_EQ(plan.chosen.deposits, plan.finest.deposits);
  EXPECT_EQ(plan.chosen.every, 1);
}

TEST(FdkPlan, SaysSoWhereNothingKeepsATimeBudget) {
  Board board = open_board("&fidelity=functional");
  const ConeGeometry geometry = small_scan(24, 24);
  const FdkPlan plan = plan_fdk(board, geometry, project(head(), geometry), {}, {0, 1'000});
  EXPECT_FALSE(plan.kept);
  EXPECT_THAT(plan.explain().front(), HasSubstr("NOT REACHED"));
}

TEST(FdkPlan, NeedsOneTarget) {
  Board board = open_board();
  const ConeGeometry geometry = small_scan(24, 24);
  const Projections projections = project(head(), geometry);
  EXPECT_THROW(plan_fdk(board, geometry, projections, {}, {}), BadArgument);
  EXPECT_THROW(plan_fdk(board, geometry, projections, {}, {0.1, 1'000'000}), BadArgument);
}

// A slab's voxels are those of the volume, and what a reconstruction leaves in them is the same but for its faces.
TEST(FdkPlan, AReconstructedSlabIsThatPartOfTheVolume) {
  Board board = open_board("&fidelity=functional");
  const ConeGeometry geometry = small_scan(32, 24);
  const Projections projections = project(head(), geometry);
  const Slab slab = slab_of(geometry, projections, 11);
  const int slices = slab.geometry.volume.dims[2];
  ASSERT_EQ(slices, 10);  // of 32, so that their middles fall together
  EXPECT_LT(slab.projections.rows, projections.rows);
  const auto whole = reconstruct_fdk(board, geometry, projections).values;
  const auto part = reconstruct_fdk(board, slab.geometry, slab.projections).values;
  double off = 0, power = 0;
  const std::size_t plane = 32 * 32, first = static_cast<std::size_t>(32 - slices) / 2 + 2;
  for (std::size_t i = 0; i < plane * static_cast<std::size_t>(slices - 4); ++i) {
    const double in_whole = whole[plane * first + i];
    off += std::pow(in_whole - part[plane * 2 + i], 2);
    power += in_whole * in_whole;
  }
  EXPECT_LT(std::sqrt(off / power), 0.03);  // samples begin where rays enter the box
}

TEST(FdkPlan, LeavesViewsOutSoThatTheOthersAreEven) {
  EXPECT_THAT(strides_of(small_scan(8, 48), 8), ElementsAre(2, 3, 4, 6));  // 8 would leave 6 views
  EXPECT_THAT(strides_of(small_scan(8, 49, 3.8), 8), ElementsAre(2, 3, 4, 6));
  const ConeGeometry geometry = small_scan(8, 12), some = some_views(geometry, 3);
  EXPECT_THAT(some.angles, ElementsAre(geometry.angles[0], geometry.angles[3], geometry.angles[6], geometry.angles[9]));
  Projections projections{1, 2, {}};
  for (int i = 0; i < 24; ++i) projections.values.push_back(static_cast<float>(i));
  EXPECT_THAT(some_views(projections, 12, 5).values, ElementsAre(0, 1, 10, 11, 20, 21));
}

}  // namespace
}  // namespace gicube::samples
