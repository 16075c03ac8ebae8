// Calls that were started: they do what the blocking calls do, in the order in which they were asked for, and can be
// cancelled.
#include <signal.h>

#include <future>

#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

using namespace std::chrono_literals;

View view_of_box(int size = 32) {
  View view;
  view.eye = {15, 16, -60}, view.look_at = {16, 16, 16};
  view.width = view.height = size;
  return view;
}

const std::vector<Light> kLights{DirectionalLight{.towards = {0, 0, -1}, .irradiance = 1000}};
const std::vector<Element> kElements{{.origin = {1, 1, 1}, .u = {4, 0, 0}, .v = {0, 4, 0}},
                                     {.origin = {1, 1, 30}, .u = {0, 4, 0}, .v = {4, 0, 0}}};
const std::vector<ElementPair> kPairs{{0, 1, 5}};

TEST(Pending, GivesBitsAndTimesOfTheBlockingCalls) {
  Board started = Board::open(kSmallBlocks), plain = Board::open(kSmallBlocks);
  const BoxVolume box(32, 8, 23);
  auto load = started.volume().start_load(box.view());
  started.set_transfer_function(step_function(0.1));  // waits for its turn
  auto light = started.light().start(kLights, {});
  auto picture = started.renderer().start(view_of_box());
  auto factors = started.pairs().start(kElements, kPairs);
  auto rays = started.rays().start(std::vector<HostRay>{{.id = 3, .position = {16, 16, 0}, .direction = {0, 0, 1}}});
  const Picoseconds now = started.now();

  plain.load_volume(box.view());
  plain.set_transfer_function(step_function(0.1));
  const LightingReport report = plain.illuminate(kLights, {});
  const Image image = plain.render(view_of_box());
  const auto expected = plain.pair_factors(kElements, kPairs);
  const Ticket ticket = plain.submit(std::vector<HostRay>{{.id = 3, .position = {16, 16, 0}, .direction = {0, 0, 1}}});
  EXPECT_EQ(now, plain.now()) << "now() waits for all that were asked for";

  EXPECT_NO_THROW(load.get());
  EXPECT_EQ(picture.get(), image);
  EXPECT_EQ(light.get().deposited, report.deposited);
  EXPECT_EQ(factors.get(), expected);
  EXPECT_EQ(rays.get().rays, plain.receive(ticket).rays);
  EXPECT_EQ(started.now(), plain.now());
}

TEST(Pending, IsReadyOnceItsCallHasEnded) {
  auto [board, id] = stopped_board();
  auto picture = board.renderer().start(view_of_box());
  EXPECT_FALSE(picture.ready());
  EXPECT_FALSE(picture.wait(30ms));
  ::kill(id, SIGCONT);
  EXPECT_TRUE(picture.wait(std::chrono::hours(1)));
  EXPECT_TRUE(picture.ready());
  const PendingProgress progress = picture.progress();
  EXPECT_GT(progress.all, 0u);
  EXPECT_EQ(progress.done, progress.all);
  EXPECT_EQ(picture.get().width, 32);
  EXPECT_THROWS(BadArgument, "pending: expected a result that was not", picture.get());
}

TEST(Pending, ThrowsWhatTheBlockingCallWould) {
  Board board = Board::open("emu:");
  auto picture = board.renderer().start(view_of_box());
  EXPECT_THROW(picture.get(), Rejected);  // no volume
  View bad = view_of_box();
  bad.step = 99;
  board.load_volume(BoxVolume(32, 8, 23).view());
  EXPECT_THROWS(BadArgument, "step: expected", board.renderer().start(bad).get());
}

TEST(Pending, KeepsAResultThatCameAfterItsDeadline) {
  Board board = Board::open("emu:");
  load_box(board);
  auto picture = board.renderer().start(view_of_box());
  EXPECT_THROWS(DeadlinePassed, "the result did not come by 1 ps of simulated time", picture.get(1));
  EXPECT_EQ(picture.get(board.now()).width, 32);
}

TEST(Pending, IsCancelledBeforeItsTurnAndDuringIt) {
  auto [board, id] = stopped_board();
  auto first = board.renderer().start(view_of_box()), second = board.renderer().start(view_of_box());
  EXPECT_TRUE(second.cancel());
  EXPECT_TRUE(first.cancel());
  EXPECT_THROW(first.get(), Cancelled);
  EXPECT_THROW(second.get(), Cancelled);
  EXPECT_FALSE(first.cancel());
  ::kill(id, SIGCONT);
  EXPECT_EQ(board.render(view_of_box()).width, 32) << "the board takes the next call";
}

TEST(Pending, ThatIsCancelledLeavesBatchesUnderWay) {
  auto [board, id] = stopped_board();
  auto batch = board.rays().start(std::vector<HostRay>{{.id = 3, .position = {16, 16, 0}, .direction = {0, 0, 1}}});
  auto picture = board.renderer().start(view_of_box());
  EXPECT_TRUE(picture.cancel());
  EXPECT_THROW(picture.get(), Cancelled);
  EXPECT_FALSE(batch.wait(300ms));
  ::kill(id, SIGCONT);
  EXPECT_TRUE(batch.wait(std::chrono::hours(1)));
  EXPECT_EQ(batch.get().rays.size(), 1u);
}

TEST(Pending, OutlivesItsBoard) {
  std::optional<Pending<Image>> picture, waiting;
  std::thread killer;
  {
    auto [board, id] = stopped_board();
    picture = board.renderer().start(view_of_box());
    waiting = board.renderer().start(view_of_box());
    killer = std::thread([&, id = id] {
      picture->wait(std::chrono::hours(1));
      ::kill(id, SIGKILL);  // or closing would wait for the process to end
    });
  }
  killer.join();
  for (Pending<Image>* each : {&*picture, &*waiting}) {
    try {
      each->get();
      ADD_FAILURE() << "a board that is closed has answered";
    } catch (const DeviceLost& error) {
      EXPECT_EQ(error.cause(), Loss::kClosed);
    }
  }
}

TEST(Pending, NeedNotBeKept) {
  Board board = Board::open("emu:");
  load_box(board);
  board.renderer().start(view_of_box());
  for (int i = 0; i < 40; ++i) board.renderer().start(view_of_box(8));
  EXPECT_EQ(board.read_framebuffer().width, 8);
}

TEST(Pending, CallsScatteringRoutinesWhichMayAskForTheTime) {
  Board board = Board::open("emu:"), plain = Board::open("emu:");
  std::optional<Pending<LightingReport>> light;
  for (Board* each : {&board, &plain}) {
    load_box(*each, 0.3);
    each->set_material({.scattering = 0.5, .bsdf = Bsdf::kTrap, .routine = kHostRoutine});
    each->set_scattering_routine([each](const ScatterEvent& event) {
      EXPECT_GT(each->now(), 0u);
      EXPECT_THROW(each->counters(), Error);
      return ScatterAnswer{event.direction};
    });
  }
  light = board.light().start(kLights, {});
  EXPECT_EQ(light->get().deposited, plain.illuminate(kLights, {}).deposited);
}

TEST(Sampling, IsTheRequestsAlone) {
  Board board = box_board();
  const std::vector<HostRay> ray{{.position = {16, 16, 0}, .direction = {0, 0, 1}}};
  const auto trace = [&](const Sampling& sampling) {
    return board.receive(board.submit(ray, {.sampling = sampling})).rays[0];
  };
  const TracedRay whole = trace({});
  EXPECT_NEAR(whole.opacity, 1 - std::pow(0.9, 16), 0.02);
  View cut = view_of_box();
  cut.cut_planes = {{{0, 0, 1}, 16}};
  board.render(cut);
  EXPECT_EQ(trace({}), whole) << "not the last view's";
  EXPECT_NEAR(trace(sampling_of(cut)).opacity, 1 - std::pow(0.9, 8), 0.02);
  EXPECT_THROWS(Rejected, "request.sampling.irradiance needs light", trace({.irradiance = true}));
}

TEST(Reads, FillTheCallersMemory) {
  Board board = box_board();
  const VoxelBox box{.low = {5, 6, 7}, .size = {9, 4, 3}};
  std::vector<float> values(std::size_t{9} * 4 * 3);
  board.volume().read(box, values);
  EXPECT_EQ(values, board.read_volume(box));
  board.illuminate(kLights, {});
  board.light().read(box, values);
  EXPECT_EQ(values, board.read_irradiance(box));
  board.clear_sums(1);
  board.light().read_sums(box, values);
  EXPECT_EQ(values, std::vector<float>(values.size()));
  values.pop_back();
  EXPECT_THROWS(BadArgument, "values: expected room for 108, 1 per voxel of the box, got 107",
                board.volume().read(box, values));
  const Image image = board.render(view_of_box());
  std::vector<Pixel> pixels(image.pixels.size());
  board.renderer().read_framebuffer(pixels);
  EXPECT_EQ(pixels, image.pixels);
  pixels.pop_back();
  EXPECT_THROWS(BadArgument, "pixels: expected 1024, as the picture has, got 1023",
                board.renderer().read_framebuffer(pixels));
}

}  // namespace
}  // namespace gicube
