#include "form_factors/plan/plan.h"

#include "form_factors/program/options.h"
#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "scene/program/board_run.h"
#include "test.h"

namespace gicube::samples {
namespace {

struct Room {
  Scene scene = read_scene(GICUBE_SOURCE_DIR "/samples/scenes/radiosity/glowing_room.scene");
  SceneSetup setup;
  Emissions emissions;

  Room() {
    scene.world->size = 8;
    scene.lighting.on = false;
    setup = set_up(scene);
    emissions = emissions_of(setup);
  }
};

TEST(RadiosityPlan, TakesMoreRaysForLessErrorAndKeepsItsBound) {
  const Room room;
  Board board = open_board({});
  const RadiosityPlan rough = plan_radiosity(board, room.setup, room.emissions, {}, {0.5, 0});
  const RadiosityPlan fine = plan_radiosity(board, room.setup, room.emissions, {}, {0.15, 0});
  EXPECT_TRUE(rough.kept && fine.kept);
  EXPECT_LE(fine.chosen.error_bound, 0.15);
  EXPECT_GT(fine.chosen.all_rays, rough.chosen.all_rays);
  RadiositySettings exact{.rays = 64, .seed = 99, .hierarchy = false};
  const RadiosityResult reference = solve_radiosity(board, room.setup, room.emissions, exact);
  EXPECT_LE(difference(fine.result, reference), fine.chosen.error_bound);
  EXPECT_LE(difference(rough.result, reference), rough.chosen.error_bound);
  EXPECT_GT(difference(rough.result, reference), 0.1 * rough.chosen.error_bound);
}

TEST(RadiosityPlan, ChoosesTheCheapestOfAllThatItFoundToKeepTheTarget) {
  std::mt19937 random(5);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Room room;
  Board board = open_board({});
  int variants = 0;
  for (int i = 0; i < 5; ++i) {
    const double error = std::exp(within(std::log(0.08), std::log(0.6)));
    SCOPED_TRACE(testing::Message() << "request " << i << ", target " << error);
    const RadiositySettings settings{.rays = 12 + 4 * (i % 2), .seed = static_cast<std::uint32_t>(random() % 1000)};
    const RadiosityPlan plan = plan_radiosity(board, room.setup, room.emissions, settings, {error, 0});
    EXPECT_EQ(plan.kept, plan.chosen.error_bound <= error);
    for (const RadiosityPlanPoint& point : plan.points) {
      if (point.error_bound > error) continue;
      EXPECT_TRUE(plan.kept);
      EXPECT_GE(point.all_rays, plan.chosen.all_rays) << "threshold " << point.threshold << ", rays " << point.rays;
    }
    variants += plan.points.size() > 3;
    const RadiosityResult again = solve_radiosity(board, room.setup, room.emissions, plan.settings);
    EXPECT_EQ(again.incident, plan.result.incident);
  }
  EXPECT_GT(variants, 0);
}

TEST(RadiosityPlan, ItsSettingsMakeTheSameSolutionAgain) {
  const Room room;
  Board board = open_board({});
  const RadiosityPlan plan = plan_radiosity(board, room.setup, room.emissions, {.seed = 7}, {0.5, 0});
  const RadiosityResult again = solve_radiosity(board, room.setup, room.emissions, plan.settings);
  EXPECT_EQ(again.incident, plan.result.incident);
}

TEST(RadiosityPlan, EndsWithAFullMatrixAndSaysSoWhereThatIsNotEnough) {
  const Room room;
  Board board = open_board({});
  const RadiosityPlan plan = plan_radiosity(board, room.setup, room.emissions, {}, {1e-4, 0});
  EXPECT_FALSE(plan.kept);
  EXPECT_THAT(plan.explain().front(), HasSubstr("NOT REACHED"));
  EXPECT_FALSE(plan.chosen.hierarchy);
}

TEST(RadiosityPlan, NeedsOneTarget) {
  const Room room;
  Board board = open_board({});
  EXPECT_THROW(plan_radiosity(board, room.setup, room.emissions, {}, {}), InputError);
  EXPECT_THROW(plan_radiosity(board, room.setup, room.emissions, {}, {0.1, 1'000'000'000}), InputError);
}

}  // namespace
}  // namespace gicube::samples
