#include "gicube/light_plan.h"

#include "plan/pilot.h"
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

// A block of fog that scatters most of a lamp's light.
struct Lamp {
  BoxVolume box{24, 4, 19};
  std::vector<Light> lights{PointLight{{11.5, 11.5, -8}, 60}};

  Board board(const std::string& uri = "emu:?fidelity=functional") const {
    Board board = Board::open(uri);
    board.load_volume(box.view());
    board.set_transfer_function(step_function(0.3));
    board.set_material({.scattering = 0.5, .bsdf = Bsdf::kIsotropic});
    return board;
  }
  LightPlanRequest request() const {
    LightPlanRequest request;
    request.lights = lights;
    request.settings.rays_per_face_voxel = 32;
    request.view = front_view(24);
    request.view.width = request.view.height = 96;
    request.view.irradiance = true;
    request.view.exposure = 20;
    return request;
  }
};

TEST(LightPlan, TakesMoreRaysForLessErrorAndKeepsItsBound) {
  const Lamp lamp;
  Board board = lamp.board();
  int last = 0;
  for (const double error : {0.2, 0.08, 0.04}) {
    LightPlanRequest request = lamp.request();
    request.max_error = error;
    const LightPlan plan = plan_light(board, request);
    EXPECT_TRUE(plan.kept) << error;
    EXPECT_LE(plan.chosen.error_bound, error);
    EXPECT_GT(plan.chosen.rays_per_face_voxel, last);
    last = plan.chosen.rays_per_face_voxel;
  }
}

TEST(LightPlan, ChoosesTheCheapestOfAllThatItFoundToKeepTheTarget) {
  const Lamp lamp;
  Board board = lamp.board();
  for (const double error : {0.9, 0.4, 0.25, 0.15, 0.1, 0.06}) {
    LightPlanRequest request = lamp.request();
    request.max_error = error;
    const LightPlan plan = plan_light(board, request);
    EXPECT_LE(plan.chosen.error_bound, error);
    for (const LightPoint& point : plan.points) {
      if (point.error_bound > error) continue;
      EXPECT_GE(point.samples, plan.chosen.samples) << error;
    }
  }
}

TEST(LightPlan, LeavesTheLightOfItsSettingsOnTheBoard) {
  const Lamp lamp;
  Board board = lamp.board(), other = lamp.board();
  LightPlanRequest request = lamp.request();
  request.max_error = 0.1;
  request.settings.seed = 5;
  const LightPlan plan = plan_light(board, request);
  other.illuminate(lamp.lights, plan.settings(request.settings));
  EXPECT_EQ(board.read_irradiance(), other.read_irradiance());
}

TEST(LightPlan, SaysSoWhereNoNumberOfRaysThatItMayTakeIsEnough) {
  const Lamp lamp;
  Board board = lamp.board();
  LightPlanRequest request = lamp.request();
  request.max_error = 1e-3;
  request.max_rays = 12;
  const LightPlan plan = plan_light(board, request);
  EXPECT_FALSE(plan.kept);
  EXPECT_EQ(plan.chosen.rays_per_face_voxel, 12);
  EXPECT_THAT(plan.explain().front(), HasSubstr("NOT REACHED"));
}

TEST(LightPlan, WithThePrintedRulesKeepsTheAlbedoWhichIsAnotherPictureThere) {
  const Lamp lamp;
  Board board = lamp.board();
  LightPlanRequest request = lamp.request();
  request.settings.rules = EnergyRules::kAsPrinted;
  request.settings.albedo = Albedo::kHigh;
  request.max_error = 0.3;
  for (const LightPoint& point : plan_light(board, request).points) EXPECT_EQ(point.albedo, Albedo::kHigh);
  request.settings.rules = EnergyRules::kConserving;
  bool low = false;
  for (const LightPoint& point : plan_light(board, request).points) low = low || point.albedo == Albedo::kLow;
  EXPECT_TRUE(low);
}

TEST(LightPlan, KeepsATimeBudgetOrSaysThatNothingDoes) {
  const Lamp lamp;
  Board board = lamp.board("emu:?fidelity=cycle");
  LightPlanRequest request = lamp.request();
  request.time_budget = 20'000'000'000;  // 20 ms
  const LightPlan plan = plan_light(board, request);
  EXPECT_TRUE(plan.kept);
  EXPECT_GT(plan.chosen.rays_per_face_voxel, 1);
  const Picoseconds begin = board.now();
  board.illuminate(lamp.lights, plan.settings(request.settings));
  EXPECT_LE(board.now() - begin, request.time_budget);
  request.time_budget = 1'000'000;  // one microsecond
  EXPECT_FALSE(plan_light(board, request).kept);
}

TEST(LightPlan, NamesWhatIsWrongWithARequest) {
  const Lamp lamp;
  Board board = lamp.board();
  LightPlanRequest request = lamp.request();
  EXPECT_THROW(plan_light(board, request), BadArgument);  // no target
  request.max_error = 0.1;
  request.time_budget = 1'000'000'000;  // both
  EXPECT_THROW(plan_light(board, request), BadArgument);
  request.max_error = 0;  // a budget, and a board without time
  EXPECT_THROW(plan_light(board, request), BadArgument);
  request = lamp.request();
  request.max_error = 0.1;
  request.max_rays = 5000;
  EXPECT_THROW(plan_light(board, request), BadArgument);
}

TEST(LightPlan, LeavesThePictureWhatTheLightDoesNotTake) {
  LightPlan light;
  light.chosen.error_bound = 0.06;
  EXPECT_NEAR(share_of_light(0.1), 0.1 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(left_for_picture(0.1, light), 0.08, 1e-12);
  light.chosen.error_bound = 0.5;  // more than it may
  EXPECT_NEAR(left_for_picture(0.1, light), 0.1 / std::sqrt(2.0), 1e-12);
}

Image image(std::uint8_t red, std::uint8_t green) { return {64, 64, std::vector<Pixel>(4096, {red, green, 0, 4095})}; }

TEST(LightPilots, NoiseIsHalfOfTheSquareBetweenTwoAndBiasIsWhatBothPairsAgreeOn) {
  const Image a = image(100, 100), b = image(110, 100);
  const double whole = std::hypot(110 / 255.0, 100 / 255.0, 1.0);
  EXPECT_NEAR(noise_of(a, b, -1).estimate, 10 / 255.0 / std::sqrt(2.0) / whole, 1e-12);
  EXPECT_NEAR(bias_of(image(120, 100), image(130, 100), a, b, -1).estimate,
              20 / 255.0 / std::hypot(100 / 255.0, 100 / 255.0, 1.0), 1e-9);
  // Differences of opposite signs are noise.
  EXPECT_EQ(bias_of(image(120, 100), image(90, 100), a, b, -1).estimate, 0);
  EXPECT_GT(bias_of(image(120, 100), image(90, 100), a, b, -1).bound, 0);
}

TEST(LightPilots, TheSquaresOfThreeChannelsAreThoseOfThePictureMadeOfThem) {
  const Image a = image(100, 40), b = image(110, 60);
  const double whole = std::pow(110 / 255.0, 2) + std::pow(60 / 255.0, 2) + 1;
  double sum = 0;
  for (int channel = 0; channel < 3; ++channel) {
    const double own = channel == 0 ? 110 / 255.0 : channel == 1 ? 60 / 255.0 : 0;
    sum += std::pow(pilot_error(a, b, channel).estimate, 2) * (own * own + 1.0 / 3);
  }
  EXPECT_NEAR(std::sqrt(sum / whole), pilot_error(a, b).estimate, 1e-12);
}

}  // namespace
}  // namespace gicube
