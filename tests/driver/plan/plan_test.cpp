#include "gicube/plan.h"

#include "plan/pilot.h"
#include "test.h"
#include "test_board.h"
#include "voxels.h"

namespace gicube {
namespace {

// A ball of soft shells in noise that nothing shows, in a corner of its volume.
struct Shells {
  static constexpr int kSize = 64;
  std::vector<std::byte> samples;
  std::vector<TransferFunction> looks{
      {{{0, {0.9, 0.5, 0.2}}, {255, {0.3, 0.6, 1}}}, {{90, 0}, {130, 0.2}, {255, 0.5}}}};

  Shells() {
    for_each_voxel({kSize, kSize, kSize}, [&](int x, int y, int z) {
      const double r = std::hypot(x - 22.0, y - 24.0, z - 21.0);
      const double value = r > 17 ? 20 + (x * 7 + y * 13 + z * 29) % 40 : 128 + 120 * std::cos(0.7 * r);
      samples.push_back(static_cast<std::byte>(static_cast<int>(value)));
    });
  }
  VolumeView volume() const { return {.samples = samples, .type = SampleType::kUint8, .dims = {kSize, kSize, kSize}}; }
  static View view(int size) {
    View view;
    view.eye = {-40, -90, 70};
    view.look_at = {22, 24, 21};
    view.up = {0, 0, 1};
    view.fov_degrees = 20;
    view.width = view.height = size;
    return view;
  }
  PlanRequest request(int size) const {
    PlanRequest request;
    request.volume = volume();
    request.looks = looks;
    request.view = view(size);
    return request;
  }
};

std::uint64_t samples_of(Board& board, const View& view) {
  const Counters before = board.counters();
  board.render_to_framebuffer(view);
  return (board.counters() - before).value("pipeline.samples");
}

TEST(Plan, LeavesThePlannedVolumeOnTheBoardAndNothingThatIsNotSeen) {
  const Shells shells;
  Board board = Board::open("emu:");
  PlanRequest request = shells.request(128);
  request.max_error = 0.02;
  const Plan plan = make_plan(board, request);
  EXPECT_LE(plan.chosen.error_bound, 0.02);
  EXPECT_LT(plan.box.size[0], 48);  // of 64
  EXPECT_EQ(plan.dims, plan.box.size);
  EXPECT_THROW(board.read_volume({{0, 0, 0}, {64, 64, 64}}), BadArgument);
  const double finest = static_cast<double>(plan.finest.samples);
  const auto chosen = static_cast<double>(samples_of(board, plan.view(request.view)));
  EXPECT_LT(3 * chosen, finest);
  EXPECT_NEAR(plan.chosen.samples, chosen, 0.1 * chosen);
}

TEST(Plan, TakesMoreSamplesForLessErrorAndFewerForMore) {
  const Shells shells;
  Board board = Board::open("emu:");
  double last = 0;
  for (const double error : {0.1, 0.03, 0.005}) {
    PlanRequest request = shells.request(128);
    request.max_error = error;
    const Plan plan = make_plan(board, request);
    EXPECT_LE(plan.chosen.error_bound, error);
    EXPECT_GT(plan.chosen.samples, last);
    last = plan.chosen.samples;
  }
}

TEST(Plan, ChoosesTheCheapestOfAllThatItFoundToKeepTheTarget) {
  Shells shells;
  Board board = Board::open("emu:");
  std::mt19937 random(3);
  const auto within = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int cheaper_than_best = 0;
  for (int i = 0; i < 24; ++i) {
    shells.looks[0].opacities = {{within(60, 120), 0}, {within(121, 180), within(0.02, 0.6)}, {255, within(0.05, 0.9)}};
    PlanRequest request = shells.request(static_cast<int>(within(40, 200)));
    request.view.eye = {within(-120, 120), within(-120, -60), within(-90, 90)};
    request.view.fov_degrees = within(15, 50);
    request.max_error = std::exp(within(std::log(0.004), std::log(0.08)));
    SCOPED_TRACE(testing::Message() << "request " << i << ", target " << request.max_error);
    const Plan plan = make_plan(board, request);
    EXPECT_LE(plan.chosen.error_bound, request.max_error);
    cheaper_than_best += plan.chosen.samples < plan.best.samples;
    for (const PlanPoint& point : plan.points) {
      if (point.error_bound > request.max_error) continue;
      EXPECT_GE(point.samples, plan.chosen.samples)
          << "level " << point.level << ", step " << point.step << ", threshold " << point.opacity_threshold;
    }
  }
  EXPECT_GT(cheaper_than_best, 8);
}

// Relative root mean square of the difference of all four channels, as gicube/plan.h has it.
double difference(const Image& image, const Image& best) { return pilot_error(image, best).estimate; }

TEST(Plan, ReachesBelowAQuarterOfAVoxelOnTheWideDatapathAlone) {
  const Shells shells;
  Board paper = Board::open("emu:"), wide = Board::open("emu:?set=asic.datapath=wide");
  PlanRequest request = shells.request(128);
  request.max_error = 0.003;
  EXPECT_EQ(make_plan(paper, request).best.step, 1.0 / 4);
  const Plan plan = make_plan(wide, request);
  EXPECT_EQ(plan.best.step, 1.0 / 16);
  EXPECT_EQ(plan.finest.samples, plan.best.samples);
  EXPECT_THAT(plan.points, testing::Contains(testing::Field(&PlanPoint::step, 1.0 / 8)));
  EXPECT_LT(plan.chosen.step, 1.0 / 4);
  EXPECT_LE(plan.chosen.error_bound, request.max_error);
  EXPECT_THAT(plan.explain(), testing::Not(testing::Contains(HasSubstr("from the best"))));
  const Image chosen = wide.render(plan.view(request.view));
  View view = plan.view(request.view);
  view.step = plan.best.step;
  view.opacity_threshold = 1;
  EXPECT_LE(difference(chosen, wide.render(view)), plan.chosen.error_bound);
}

TEST(Plan, ShorterStepsComeNearerToTheFinestOfTheWideDatapath) {
  const Shells shells;
  Board board = Board::open("emu:?set=asic.datapath=wide");
  board.load_volume(shells.volume());
  board.set_transfer_function(shells.looks[0]);
  View view = Shells::view(96);
  view.opacity_threshold = 1;
  const auto picture = [&](double step) {
    view.step = step;
    return board.render(view);
  };
  const Image finest = picture(1.0 / 64);
  double last = 1;
  for (const double step : {1.0 / 2, 1.0 / 4, 1.0 / 8, 1.0 / 16}) {
    const double error = difference(picture(step), finest);
    EXPECT_LT(error, 0.8 * last) << step;
    last = error;
  }
}

TEST(Plan, TakesACoarserVolumeWherePixelsAreLargerThanVoxelsAndNothingIsThin) {
  Shells shells;
  Board board = Board::open("emu:");
  PlanRequest request = shells.request(24);
  request.view.fov_degrees = 60;  // a ball of five pixels
  request.max_error = 0.2;
  const Plan thin = make_plan(board, request);
  EXPECT_GT(thin.level_for_pixels, 0);
  EXPECT_EQ(thin.chosen.level, 0);
  EXPECT_GT(thin.level_errors.at(0).largest_density, 2000);

  for (std::size_t i = 0; i < shells.samples.size(); ++i) {
    const std::size_t plane = i / 4096, row = i / 64 % 64;
    const auto x = static_cast<double>(i % 64), y = static_cast<double>(row), z = static_cast<double>(plane);
    const double r = std::hypot(x - 22, y - 24, z - 21) / 20;
    shells.samples[i] = static_cast<std::byte>(static_cast<int>(200 * std::exp(-r * r)));
  }
  const Plan smooth = make_plan(board, request);
  EXPECT_GT(smooth.chosen.level, 0);
  EXPECT_LT(smooth.level_errors.at(0).largest_density, 200);
  EXPECT_LE(smooth.chosen.error_bound, 0.2);
}

TEST(Plan, KeepsATimeBudgetOrSaysThatNothingDoes) {
  const Shells shells;
  Board board = Board::open("emu:?fidelity=cycle");
  PlanRequest request = shells.request(128);
  request.time_budget = 8'000'000'000;  // 8 ms; the finest setting takes 18
  const Plan plan = make_plan(board, request);
  EXPECT_TRUE(plan.kept);
  EXPECT_GT(plan.finest.time, request.time_budget);
  const Picoseconds begin = board.now();
  board.render(plan.view(request.view));
  EXPECT_LE(board.now() - begin, request.time_budget);

  request.time_budget = 1'000'000;  // one microsecond
  const Plan hopeless = make_plan(board, request);
  EXPECT_FALSE(hopeless.kept);
  EXPECT_THAT(hopeless.explain().front(), HasSubstr("NOT REACHED"));
}

TEST(Plan, ABudgetNeedsABoardThatKeepsTime) {
  const Shells shells;
  Board board = Board::open("emu:?fidelity=functional");
  PlanRequest request = shells.request(32);
  request.time_budget = 1'000'000'000;
  EXPECT_THROW(make_plan(board, request), BadArgument);
  request.max_error = 0.01;  // both
  EXPECT_THROW(make_plan(board, request), BadArgument);
}

TEST(Plan, MakesNoGradientsForAPictureWithoutShading) {
  const Shells shells;
  Board board = Board::open("emu:");
  PlanRequest request = shells.request(64);
  request.view.shade = false;
  request.max_error = 0.05;
  const Plan plan = make_plan(board, request);
  EXPECT_FALSE(plan.gradients);
  const Image flat = board.render(plan.view(request.view));
  View shaded = plan.view(request.view);
  shaded.shade = true;
  EXPECT_EQ(board.render(shaded), flat);  // there is no gradient to shade by
  EXPECT_THAT(plan.explain(), testing::Contains(HasSubstr("gradients")));
}

TEST(Plan, BringsAnotherBoardToTheSamePicture) {
  const Shells shells;
  Board board = Board::open("emu:"), other = Board::open("emu:");
  PlanRequest request = shells.request(64);
  request.max_error = 0.1;
  const Plan plan = make_plan(board, request);
  load_planned(other, plan, request.volume, request.looks);
  EXPECT_EQ(other.render(plan.view(request.view)), board.render(plan.view(request.view)));
}

TEST(Plan, OfWhatTheBoardHoldsChangesNoVolume) {
  const Shells shells;
  Board board = Board::open("emu:");
  board.load_volume(shells.volume());
  board.set_transfer_function(shells.looks[0]);
  const auto before = board.read_volume({{0, 0, 0}, {64, 64, 4}});
  PlanRequest request;
  request.view = Shells::view(96);
  request.max_error = 0.02;
  const Plan plan = make_plan(board, request);
  EXPECT_EQ(board.read_volume({{0, 0, 0}, {64, 64, 4}}), before);
  EXPECT_EQ(plan.placement.edge, 1);
  EXPECT_EQ(plan.chosen.level, 0);
  EXPECT_GT(plan.finest.samples, 3 * plan.chosen.samples);
}

TEST(Plan, APictureOfNothingKeepsTheBestSetting) {
  const Shells shells;
  Board board = Board::open("emu:");
  PlanRequest request = shells.request(64);
  request.view.look_at = {22, -400, 21};  // away from it
  request.max_error = 0.05;
  const Plan plan = make_plan(board, request);
  EXPECT_EQ(plan.chosen.step, plan.best.step);
  EXPECT_EQ(plan.chosen.opacity_threshold, 1);
}

Image flat(int size, Pixel pixel) {
  return {size, size, std::vector<Pixel>(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), pixel)};
}

TEST(PilotError, IsRelativeAndItsBoundGrowsWithItsSpread) {
  const Image best = flat(16, {100, 100, 100, 2000});
  Image even = best, single = best;
  for (Pixel& pixel : even.pixels) pixel.red = 110;
  single.pixels[7].red = 100 + 10 * 15;  // nearly the same sum of squares, in one pixel
  const PilotError everywhere = pilot_error(even, best), in_one = pilot_error(single, best);
  const double whole = std::sqrt(3 * std::pow(100 / 255.0, 2) + std::pow(2000 / 4095.0, 2));
  EXPECT_NEAR(everywhere.estimate, 10 / 255.0 / whole, 1e-12);
  EXPECT_NEAR(in_one.estimate, everywhere.estimate * 15 / 16, 1e-12);
  EXPECT_LT(everywhere.bound, 1.3 * everywhere.estimate);
  EXPECT_GT(in_one.bound, 2 * in_one.estimate);
}

TEST(PilotError, OfABlankBestPictureIsNotKnown) {
  EXPECT_TRUE(std::isinf(pilot_error(flat(8, {}), flat(8, {})).bound));
}

TEST(ExtrapolatedTime, FollowsCommandBordersAndRays) {
  const auto time = [](double rays) { return 5 + 2 * std::sqrt(rays) + 0.5 * rays; };
  const auto at = [&](double rays) { return TimePoint{rays, time(rays)}; };
  EXPECT_NEAR(extrapolated_time({0, 5}, at(100), at(400), 10000), time(10000), 1e-9);
  EXPECT_NEAR(extrapolated_time({0, 5}, at(100), {}, 200), 5 + 2 * (time(100) - 5), 1e-9);
}

}  // namespace
}  // namespace gicube
