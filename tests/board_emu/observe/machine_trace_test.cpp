#include "observe/machine_trace.h"

#include "observe/observation.h"
#include "observed_scene.h"
#include "read_trace.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr std::int64_t kCycleNs = 10;

std::string name(std::size_t processor, const char* track) {
  return "processor " + std::to_string(processor) + '/' + track;
}

// Renders `frames` pictures under the trace, the first from `at`, each behind the one before.
ReadTrace traced(const v1::BoardConfig& config, Machine& machine, int frames = 1, Picoseconds at = 5'000'000) {
  const reference::TemporaryDirectory folder;
  const ObservedScene scene;
  {
    TraceFile file(folder.file("t"));
    MachineTrace trace(file);
    trace.power_up(0, config);
    machine.set_observer(&trace);
    for (int i = 0; i < frames; ++i) {
      trace.begin(at);
      cycle_picture(scene, corner_view(kObservedSize, 24), machine);
      trace.end();
      at = trace.end_ps() + 1'000'000;
    }
    machine.set_observer(nullptr);
  }
  return read_trace(read_text(folder.file("t")));
}

TEST(MachineTrace, TheCausesOfATrackAreTheCountersOfTheProcessor) {
  for (const auto& more : std::vector<std::vector<std::string>>{{}, {"sorter.queues=single"}, {"dsp.clock_khz=4000"}}) {
    const v1::BoardConfig config = observed_config(more);
    Machine machine(config, {3, 3, 3});
    const ReadTrace trace = traced(config, machine);
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      const std::string track = name(i, "pipeline");
      for (std::size_t cause = 0; cause < kCauses; ++cause) {
        EXPECT_EQ(trace.sum(track, std::string(kCauseNames[cause])), machine.processors()[i]->causes()[cause])
            << track << ' ' << kCauseNames[cause];
      }
    }
  }
}

TEST(MachineTrace, PipelineSlicesCoverTheCommandWithoutAGap) {
  const v1::BoardConfig config = observed_config();
  Machine machine(config, {3, 3, 3});
  const ReadTrace trace = traced(config, machine);
  for (std::size_t i = 0; i < machine.processors().size(); ++i) {
    const auto& slices = trace.slices.at(name(i, "pipeline"));
    EXPECT_EQ(slices.back().end_ns, 5000 + static_cast<std::int64_t>(machine.now()) * kCycleNs);
    for (std::size_t s = 0; s < slices.size(); ++s) {
      EXPECT_EQ(slices[s].begin_ns, s > 0 ? slices[s - 1].end_ns : 5000);
      std::int64_t cycles = 0;
      for (const auto& count : slices[s].args) cycles += count.get<std::int64_t>();
      EXPECT_EQ(cycles * kCycleNs, slices[s].end_ns - slices[s].begin_ns);
      EXPECT_TRUE(slices[s].args.contains(slices[s].name));
    }
  }
}

TEST(MachineTrace, ActiveBlocksAreThoseOfTheProcessorAndIssueItsRays) {
  const v1::BoardConfig config = observed_config();
  Machine machine(config, {3, 3, 3});
  const ReadTrace trace = traced(config, machine);
  for (std::size_t i = 0; i < machine.processors().size(); ++i) {
    const auto& slices = trace.slices.at(name(i, "active block"));
    EXPECT_EQ(slices.size(), machine.processors()[i]->sorter().counters().activations);
    EXPECT_EQ(trace.sum(name(i, "active block"), "rays"), machine.processors()[i]->sorter().counters().issued);
    for (const ReadSlice& slice : slices) {
      int x = -1, y = -1, z = -1;
      ASSERT_EQ(std::sscanf(slice.name.c_str(), "block %d %d %d", &x, &y, &z), 3) << slice.name;
      EXPECT_EQ(static_cast<std::size_t>(x + y + z) % 3, i) << slice.name;  // skewed blocks
      const Home& home = machine.partition().home(static_cast<std::size_t>(x + 3 * (y + 3 * z)));
      EXPECT_EQ(slice.args.at("queue"), home.number);
    }
  }
}

TEST(MachineTrace, TheBaselineHasNoActiveBlock) {
  const v1::BoardConfig config = observed_config({"sorter.queues=single"});
  Machine machine(config, {3, 3, 3});
  const ReadTrace trace = traced(config, machine);
  EXPECT_THAT(trace.slices.at(name(0, "active block")), testing::Each(testing::Field(&ReadSlice::name, "all blocks")));
}

TEST(MachineTrace, CountersSumUpAndEndAtNothing) {
  const v1::BoardConfig config = observed_config();
  Machine machine(config, {3, 3, 3});
  const ReadTrace trace = traced(config, machine);
  for (std::size_t i = 0; i < machine.memories().size(); ++i) {
    const auto& rates = trace.counters.at("memory/RDRAM " + std::to_string(i) + " packets/us");
    std::uint64_t packets = 0;
    for (std::size_t s = 0; s + 1 < rates.size(); ++s) {
      EXPECT_LT(rates[s].first, rates[s + 1].first);
      packets += rates[s].second * static_cast<std::uint64_t>(rates[s + 1].first - rates[s].first) / 1000;
    }
    EXPECT_EQ(rates.back().second, 0u);
    const std::uint64_t all = machine.memories()[i]->channel().counters().packets_read;
    EXPECT_LE(packets, all);
    EXPECT_GE(packets + 100, all);  // the last, shorter microsecond is not shown
    EXPECT_GT(all, 300u);
  }
  EXPECT_EQ(trace.counters.at("processor 1/rays waiting").back().second, 0u);
  EXPECT_EQ(trace.counters.at("links/rays on links").back().second, 0u);
}

TEST(MachineTrace, CommandsFollowOneAnotherAndMachinesToo) {
  const v1::BoardConfig config = observed_config();
  const reference::TemporaryDirectory folder;
  const ObservedScene scene;
  Cycle cycles = 0;
  {
    TraceFile file(folder.file("t"));
    MachineTrace trace(file);
    trace.power_up(0, config);
    Picoseconds at = 0;
    for (int i = 0; i < 2; ++i) {
      Machine machine(config, {3, 3, 3});
      machine.set_observer(&trace);
      for (int frame = 0; frame < 2; ++frame) {
        trace.begin(at);
        cycle_picture(scene, corner_view(kObservedSize, 12), machine);
        trace.end();
        at = trace.end_ps() + 1'000'000;
      }
      cycles += machine.now();
    }
  }
  const ReadTrace trace = read_trace(read_text(folder.file("t")));
  std::int64_t ns = 0;
  for (const ReadSlice& slice : trace.slices.at(name(2, "pipeline"))) ns += slice.end_ns - slice.begin_ns;
  EXPECT_EQ(ns, static_cast<std::int64_t>(cycles) * kCycleNs);
}

TEST(MachineTrace, ObservingChangesNoBitAndNoCycle) {
  class Nothing : public Observer {
    void see(Cycle, const Machine&) override {}
  };
  for (const auto& more : std::vector<std::vector<std::string>>{{}, {"dsp.clock_khz=4000"}, {"dsp.run_rays=8"}}) {
    const v1::BoardConfig config = observed_config(more);
    const ObservedScene scene;
    const wire::RenderCommand view = corner_view(kObservedSize, 24);
    Machine plain(config, {3, 3, 3}), observed(config, {3, 3, 3});
    Nothing nothing;
    observed.set_observer(&nothing);
    for (int frame = 0; frame < 2; ++frame) {
      const RunRules runs = runs_of(config);
      const Picture a = cycle_picture(scene, view, plain, runs), b = cycle_picture(scene, view, observed, runs);
      EXPECT_EQ(a.pixels, b.pixels);
      EXPECT_EQ(a.ran.cycles, b.ran.cycles);
    }
    std::vector<wire::Counter> a, b;
    count(plain, a);
    count(observed, b);
    EXPECT_EQ(a, b);
  }
}

}  // namespace
}  // namespace gicube::emu
