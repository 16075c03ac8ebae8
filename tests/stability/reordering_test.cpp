// Reordering: queues shorter than the pipeline, the tail of a frame, and volumes that are fine for their image.
#include <cmath>
#include <string>
#include <vector>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr const char* kOneProcessor = "&fidelity=cycle&set=asic.processors=1";

struct Machine {
  explicit Machine(const std::string& options, int size = 32)
      : board(Board::open(small_board(kOneProcessor + options))) {
    load_fog(board, {size, size, size}, 0.001);
  }
  // Of what was done since the machine was last asked.
  Counters window() {
    const Counters now = board.counters();
    Counters grown = before.list().empty() ? now : now - before;
    before = now;
    return grown;
  }

  Board board;
  Counters before;
};

View frame(int size, int image) {
  View view = front_view(size);
  view.eye = {-40, -30, -60};
  view.orthographic_height = 1.4 * size;
  view.width = view.height = image;
  view.step = 1;
  return view;
}

double packets_a_sample(const Counters& window) {
  return ratio(window.value("processor.cache.packets"), window.value("processor.samples"));
}

// A turn of the pipeline takes 35 cycles: a queue of fewer rays can't fill it, and the next block has its turn before
// the first rays come back.
TEST(StabilityOfReordering, QueuesShorterThanThePipelineGoOnAndShowTheirThrashing) {
  Machine shorter("&set=asic.queue_rays=4"), longer("&set=asic.queue_rays=256");
  shorter.window();
  longer.window();
  const Image picture = longer.board.render(frame(32, 64));
  const Counters calm = longer.window();
  EXPECT_EQ(shorter.board.render(frame(32, 64)).pixels, picture.pixels);
  const Counters thrash = shorter.window();
  EXPECT_EQ(thrash.value("processor.samples"), calm.value("processor.samples"));
  EXPECT_GT(thrash.value("dsp.overflows"), 0u);
  EXPECT_GT(packets_a_sample(thrash), 2.3 * packets_a_sample(calm));
  EXPECT_GT(thrash.value("processor.sorter.activations"), 3 * calm.value("processor.sorter.activations"));
  record("packets_a_sample_queues_of_256", packets_a_sample(calm));
  record("packets_a_sample_queues_of_4", packets_a_sample(thrash));
  record("time_of_queues_of_4_over_256", ratio(thrash.value("asic.cycles"), calm.value("asic.cycles")));
}

// The end of a pass: a few rays each in two blocks that take the same places in the cache. Alone, either fetches its
// tiles once; together they take turns after each sample.
TEST(StabilityOfReordering, TheTailOfAFewRaysInTwoBlocksTakesTurnsAndEnds) {
  const auto rays_in = [](double x) {
    std::vector<HostRay> rays;
    for (std::uint32_t i = 0; i < 3; ++i)
      rays.push_back(ray_between(i, {x + 1.5 + i, 2.5, 0.5}, {x + 1.5 + i, 2.5, 7.0}));
    return rays;
  };
  const auto packets = [](const std::vector<HostRay>& rays) {
    Machine machine("");
    machine.window();
    machine.board.receive(machine.board.submit(rays, {.type = RayType::kOpacity, .step = 0.125, .leap = false}));
    const Counters window = machine.window();
    EXPECT_EQ(window.value("processor.samples"), rays.size() * 52);
    return window.value("processor.cache.packets");
  };
  std::vector<HostRay> both = rays_in(0);
  const std::uint64_t one = packets(both), other = packets(rays_in(16));
  for (const HostRay& ray : rays_in(16)) both.push_back(ray);
  const std::uint64_t together = packets(both);
  EXPECT_GT(together, 5 * (one + other));
  record("packets_of_two_tails_over_those_of_each", ratio(together, one + other));
}

// 512^3 with 256^2, and the same with 64^3 and 32^2: rays two voxels apart share no tile, so each sample pays for its
// own.
TEST(StabilityOfReordering, AVolumeTooFineForItsImagePaysInPacketsASample) {
  Machine machine("", 64);
  machine.board.render(frame(64, 8));
  machine.window();
  const Image coarse = machine.board.render(frame(64, 32));
  const Counters few = machine.window();
  machine.board.render(frame(64, 128));
  const Counters many = machine.window();
  EXPECT_GT(packets_a_sample(few), 1.5 * packets_a_sample(many));
  record("packets_a_sample_rays_2.8_voxels_apart", packets_a_sample(few));
  record("packets_a_sample_rays_0.7_voxels_apart", packets_a_sample(many));
  Board functional = Board::open(small_board());
  load_fog(functional, {64, 64, 64}, 0.001);
  EXPECT_EQ(functional.render(frame(64, 32)).pixels, coarse.pixels);
}

}  // namespace
}  // namespace gicube::stability
