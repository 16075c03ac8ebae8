// The cycle level behind the board's connector: time, counters and faults as a host sees them.
#include "bare_board.h"
#include "test.h"

namespace gicube::emu {
namespace {

v1::BoardConfig cycle_config(unsigned block_voxels = 8) {
  v1::BoardConfig config;
  config.set_fidelity(v1::cycle);
  config.set_threads(1);
  config.mutable_asic()->set_block_voxels(block_voxels);
  return config;
}

void load_cloud(BareBoard& board, const std::array<int, 3>& size) {
  board.load_volume(size, [](int x, int y, int z) {
    return wire::Voxel{static_cast<std::uint16_t>((x * 37 + y * 91 + z * 53) % 4096), 0, 0, 0};
  });
  board.write_segmentation([](unsigned, unsigned density) {
    return wire::SegmentationEntry{{2048, 1024, 512}, static_cast<std::uint16_t>(density / 4)};
  });
}

std::uint64_t sum(const BareBoard& board, const std::string& prefix) {
  std::uint64_t all = 0;
  for (const wire::Counter& counter : board.counters()) {
    if (counter.name.starts_with(prefix)) all += counter.value;
  }
  return all;
}

TEST(CycleLevel, ACommandTakesAsLongAsItsCyclesOnTheAsic) {
  BareBoard board(cycle_config());
  load_cloud(board, {30, 30, 30});
  board.read_register(wire::reg::kId);  // the bus is quiet
  const std::uint64_t begin = board.now_ps;
  const auto payload = wire::encoded(corner_view({30, 30, 30}, 24));
  const TransactionResult outcome = board.wait(board.command(payload));
  const std::uint64_t cycles = board.counter("asic.cycles");
  EXPECT_GT(cycles, 3000u);
  // 10 ns a cycle; command down and completion up take less than 2 us.
  EXPECT_GE(outcome.completions.at(0).time_ps - begin, cycles * 10'000);
  EXPECT_LT(outcome.completions.at(0).time_ps - begin, cycles * 10'000 + 2'000'000);
}

TEST(CycleLevel, HostRaysComeBackWithTheFunctionalLevelsBits) {
  BareBoard cycle(cycle_config());
  v1::BoardConfig config = cycle_config();
  config.set_fidelity(v1::functional);
  BareBoard functional(config);
  std::vector<wire::Ray> rays;
  for (unsigned i = 0; i < 200; ++i) {
    rays.push_back(host_ray(7 * i, {i % 29 + 0.3, i * 13 % 29 + 0.7, 3.0 + i % 5}, {std::cos(i), std::sin(i), 0.4}));
  }
  load_cloud(cycle, {30, 30, 30});
  load_cloud(functional, {30, 30, 30});
  const auto traced = cycle.trace(rays);
  EXPECT_EQ(traced, functional.trace(rays));
  EXPECT_NE(traced, rays);
  EXPECT_EQ(cycle.counter("pipeline.samples"), functional.counter("pipeline.samples"));
}

TEST(CycleLevel, TheHostBusAndThreadsChangeNoBit) {
  std::vector<wire::Pixel> expected;
  for (const auto model : {v1::pci33, v1::agp1x, v1::agp2x, v1::agp4x}) {
    for (const unsigned threads : {1u, 3u}) {
      v1::BoardConfig config = cycle_config();
      config.mutable_bus()->set_model(model);
      config.set_threads(threads);
      BareBoard board(config);
      load_cloud(board, {30, 30, 30});
      const auto image = board.render(corner_view({30, 30, 30}, 24));
      if (expected.empty()) expected = image;
      EXPECT_EQ(image, expected);
    }
  }
}

TEST(CycleLevel, CausesOfAllProcessorsSumToTheirCycles) {
  v1::BoardConfig config = cycle_config();
  config.mutable_asic()->set_processors(3);
  BareBoard board(config);
  load_cloud(board, {30, 30, 30});
  board.render(corner_view({30, 30, 30}, 24));
  EXPECT_EQ(sum(board, "processor.cycles."), 3 * board.counter("asic.cycles"));
  EXPECT_EQ(board.counter("processor.cycles.busy"), board.counter("pipeline.samples"));
  EXPECT_EQ(sum(board, "asic.block_loads.ms"), board.counter("processor.sorter.activations"));
  EXPECT_EQ(sum(board, "asic.samples.ms"), board.counter("processor.samples"));
  EXPECT_EQ(sum(board, "processor.sorter.activations_of_rays."), board.counter("processor.sorter.activations"));
  EXPECT_EQ(sum(board, "processor.sorter.issued_in_activations_of_rays."), board.counter("processor.sorter.issued"));
}

TEST(CycleLevel, CountersGoOnWhenAVolumeOfAnotherSizeComes) {
  BareBoard board(cycle_config());
  load_cloud(board, {30, 30, 30});
  board.render(corner_view({30, 30, 30}, 16));
  const std::uint64_t cycles = board.counter("asic.cycles"), samples = board.counter("processor.samples");
  load_cloud(board, {20, 40, 20});
  EXPECT_EQ(board.counter("asic.cycles"), cycles);
  board.render(corner_view({20, 40, 20}, 16));
  EXPECT_GT(board.counter("asic.cycles"), cycles);
  EXPECT_GT(board.counter("processor.samples"), samples);
  EXPECT_EQ(board.counter("processor.samples"), board.counter("pipeline.samples"));
}

TEST(CycleLevel, AChangedVolumeIsNotReadFromOldCaches) {
  BareBoard board(cycle_config(16));
  load_cloud(board, {16, 16, 16});
  board.render(corner_view({16, 16, 16}, 16));
  const std::uint64_t cold = board.counter("processor.cache.packets");
  board.render(corner_view({16, 16, 16}, 16));
  EXPECT_EQ(board.counter("processor.cache.packets"), cold);
  load_cloud(board, {16, 16, 16});
  board.render(corner_view({16, 16, 16}, 16));
  EXPECT_EQ(board.counter("processor.cache.packets"), 2 * cold);
}

TEST(CycleLevel, ACancelledFrameLeavesAWorkingBoard) {
  BareBoard board(cycle_config());
  load_cloud(board, {30, 30, 30});
  const auto image = board.render(corner_view({30, 30, 30}, 40));
  board.work.cancel = true;
  const auto payload = wire::encoded(corner_view({30, 30, 30}, 40));
  EXPECT_EQ(board.wait(board.command(payload)).completions.at(0).error, wire::ErrorCode::kCancelled);
  board.work.cancel = false;
  EXPECT_EQ(board.render(corner_view({30, 30, 30}, 40)), image);
}

std::uint64_t sum(const std::vector<std::uint32_t>& values) {
  return std::accumulate(values.begin(), values.end(), std::uint64_t{0});
}

void expect_kept(const Board::Snapshot& seen) {
  const auto value = [&seen](const std::string& name) {
    const auto found = std::ranges::find(seen.counters, name, &wire::Counter::name);
    return found == seen.counters.end() ? 0 : found->value;
  };
  EXPECT_EQ(seen.machine.cycle, value("asic.cycles"));
  EXPECT_EQ(sum(seen.machine.waiting), value("processor.sorter.written") - value("processor.sorter.issued"));
  EXPECT_EQ(sum(seen.machine.processors), sum(seen.machine.waiting));
  std::uint64_t packets = 0;
  for (const auto& memory : seen.machine.packets) {
    packets = std::accumulate(memory.begin(), memory.end(), packets);
  }
  EXPECT_EQ(packets, value("rdram.reads") + value("rdram.writes"));
}

TEST(CycleLevel, WhoAsksInMidCommandSeesRaysWaitAndWhoAsksLaterSeesItsEnd) {
  v1::BoardConfig config = cycle_config();
  config.mutable_ideal()->set_dsp(1);  // rays come faster than they are traced
  BareBoard board(config);
  load_cloud(board, {30, 30, 30});
  EXPECT_TRUE(board.snapshot().machine.processors.empty()) << "no command has come";
  std::atomic<bool> ended = false;
  std::thread host([&] {
    board.render(corner_view({30, 30, 30}, 200));
    ended = true;
  });
  std::uint64_t most = 0;
  int looks = 0;
  for (Cycle last = 0; !ended;) {
    const Board::Snapshot seen = board.snapshot();
    if (seen.machine.cycle != last) {
      expect_kept(seen);
      most = std::max(most, sum(seen.machine.waiting));
      last = seen.machine.cycle;
      ++looks;
    }
    std::this_thread::yield();
  }
  host.join();
  EXPECT_GE(looks, 2);
  EXPECT_GT(most, 100u);
  const Board::Snapshot end = board.snapshot();
  expect_kept(end);
  EXPECT_EQ(sum(end.machine.waiting), 0u);
  EXPECT_EQ(end.machine.cycle, board.counter("asic.cycles"));
}

TEST(CycleLevel, NobodyWhoAsksIsNoLookAtTheMachine) {
  BareBoard board(cycle_config());
  load_cloud(board, {30, 30, 30});
  board.render(corner_view({30, 30, 30}, 24));
  EXPECT_TRUE(board.snapshot().machine.processors.empty());
  board.render(corner_view({30, 30, 30}, 24));
  EXPECT_EQ(board.snapshot().machine.processors.size(), 4u);
}

TEST(CycleLevel, ResetStartsTheMachineAnew) {
  BareBoard board(cycle_config());
  load_cloud(board, {30, 30, 30});
  const auto image = board.render(corner_view({30, 30, 30}, 16));
  board.write_register(wire::reg::kControl, wire::kControlReset);
  load_cloud(board, {30, 30, 30});
  EXPECT_EQ(board.render(corner_view({30, 30, 30}, 16)), image);
}

}  // namespace
}  // namespace gicube::emu
