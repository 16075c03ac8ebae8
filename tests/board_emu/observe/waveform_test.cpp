#include "observe/waveform.h"

#include "observe/observation.h"
#include "observed_scene.h"
#include "read_trace.h"
#include "read_vcd.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

// What the signals should be, asked of the parts themselves, a record a cycle.
class Recorder : public Observer {
 public:
  void see(Cycle now, const Machine& machine) override {
    auto& values = cycles[now];
    const auto binary = [](std::uint64_t value) {
      std::string text;
      for (; value > 1; value /= 2) text.insert(text.begin(), value % 2 == 0 ? '0' : '1');
      return std::string(value == 0 ? "0" : "1") + text;
    };
    values["board.dsp_busy"] = machine.dsp().free_at() > now ? "1" : "0";
    values["board.ray_bus_busy"] = machine.ray_bus().counters().busy > bus_before_ ? "1" : "0";
    bus_before_ = machine.ray_bus().counters().busy;
    values["board.link_rays"] = binary(machine.links().inside());
    values["board.fifo_down"] = binary(machine.down().size());
    values["board.fifo_up"] = binary(machine.up().size());
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      const Processor& processor = *machine.processors()[i];
      const std::string scope = "board.processor" + std::to_string(i) + '.';
      for (std::size_t cause = 0; cause < kCauses; ++cause) {
        if (processor.causes()[cause] > before_[i][cause]) values[scope + "cause"] = binary(cause);
        before_[i][cause] = processor.causes()[cause];
      }
      const Sorter& sorter = processor.sorter();
      std::string& active = values[scope + "active_queue"];
      active = "z";
      if (sorter.has_active()) {
        active = binary(sorter.active());
      } else if (held_[i] != "z") {
        active = held_[i];  // given up in this cycle
      } else if (sorter.counters().issued > issued_[i]) {
        active = binary(sorter.latest_active());  // chosen and given up in this cycle
      }
      held_[i] = sorter.has_active() ? active : "z";
      issued_[i] = sorter.counters().issued;
      values[scope + "rays_waiting"] = binary(processor.sorter().waiting());
      values[scope + "prefetch"] = binary(processor.stages().prefetching());
      values[scope + "compute"] = binary(processor.stages().computing());
      values[scope + "packets_under_way"] = binary(processor.misses().size());
      values[scope + "fifo_from_left"] = binary(processor.from_left.size());
      values[scope + "fifo_done"] = binary(processor.done.size());
    }
  }

  std::map<Cycle, std::map<std::string, std::string>> cycles;

 private:
  std::uint64_t bus_before_ = 0;
  std::map<std::size_t, CauseCounts> before_;
  std::array<std::string, 16> held_ = filled();
  std::array<std::uint64_t, 16> issued_{};

  static std::array<std::string, 16> filled() {
    std::array<std::string, 16> names;
    names.fill("z");
    return names;
  }
};

class Both : public Observer {
 public:
  Both(Observer& first, Observer& second) : observers_{&first, &second} {}
  void see(Cycle now, const Machine& machine) override {
    for (Observer* observer : observers_) observer->see(now, machine);
  }

 private:
  std::array<Observer*, 2> observers_;
};

struct Recorded {
  ReadVcd vcd;
  Recorder recorder;
  Cycle cycles = 0;
};

Recorded record(const v1::BoardConfig& config, const CycleWindow& window) {
  const reference::TemporaryDirectory folder;
  const ObservedScene scene;
  Recorded recorded;
  {
    Waveform waveform(folder.file("v"), window);
    waveform.set_clock(config.asic().core_khz());
    Both both(recorded.recorder, waveform);
    Machine machine(config, {3, 3, 3});
    machine.set_observer(&both);
    cycle_picture(scene, corner_view(kObservedSize, 16), machine);
    recorded.cycles = machine.now();
  }
  recorded.vcd = read_vcd(read_text(folder.file("v")));
  return recorded;
}

void expect_same(const Recorded& recorded, const CycleWindow& window, std::uint64_t units_a_cycle) {
  for (Cycle cycle = window.begin; cycle < window.end; ++cycle) {
    for (const auto& [signal, value] : recorded.recorder.cycles.at(cycle)) {
      ASSERT_EQ(recorded.vcd.at(signal, cycle * units_a_cycle), value) << signal << " at cycle " << cycle;
    }
  }
}

TEST(Waveform, HasTheValuesThatAnotherObserverSees) {
  const CycleWindow window{900, 2100};
  const Recorded recorded = record(observed_config(), window);
  EXPECT_EQ(recorded.vcd.timescale, "10 ns");
  EXPECT_EQ(recorded.vcd.begin, window.begin);
  EXPECT_EQ(recorded.vcd.end, window.end);
  EXPECT_EQ(recorded.vcd.signals.size(), 6u + 3 * 12);
  expect_same(recorded, window, 1);
}

TEST(Waveform, ShowsCyclesInWhichOnlyTheDspWorks) {
  const CycleWindow window{0, 5000};
  const Recorded recorded = record(observed_config({"dsp.clock_khz=4000"}), window);
  EXPECT_EQ(recorded.recorder.cycles.size(), recorded.cycles);  // not one is left out
  expect_same(recorded, window, 1);
}

TEST(Waveform, EndsWithItsMachineIfThatIsBeforeTheWindow) {
  const Recorded recorded = record(observed_config(), {10, 1'000'000'000});
  EXPECT_EQ(recorded.vcd.begin, 10u);
  EXPECT_EQ(recorded.vcd.end, recorded.cycles);
}

TEST(Waveform, AWindowThatNobodyReachedIsAnEmptyWaveform) {
  const Recorded recorded = record(observed_config(), {1'000'000'000, 1'000'000'001});
  EXPECT_TRUE(recorded.vcd.signals.empty());
}

TEST(Waveform, TheUnitOfTimeIsTheCoarsestThatMeetsTheClock) {
  const CycleWindow window{100, 200};
  const Recorded slow = record(observed_config({"asic.core_khz=1000"}), window);
  EXPECT_EQ(slow.vcd.timescale, "1 us");
  expect_same(slow, window, 1);
  const Recorded odd = record(observed_config({"asic.core_khz=80000"}), window);  // 12.5 ns
  EXPECT_EQ(odd.vcd.timescale, "100 ps");
  expect_same(odd, window, 125);
  const Recorded broken = record(observed_config({"asic.core_khz=133333"}), window);  // 7500.02 ps
  EXPECT_EQ(broken.vcd.timescale, "1 ps");
  EXPECT_EQ(broken.vcd.begin, 750'001u);
}

TEST(Waveform, IsOfOneMachine) {
  const reference::TemporaryDirectory folder;
  const ObservedScene scene;
  const v1::BoardConfig config = observed_config();
  Cycle first = 0;
  {
    Waveform waveform(folder.file("v"), {5, 1'000'000});
    waveform.set_clock(config.asic().core_khz());
    for (int i = 0; i < 2; ++i) {
      Machine machine(config, {3, 3, 3});
      machine.set_observer(&waveform);
      cycle_picture(scene, corner_view(kObservedSize, 12), machine);
      if (i == 0) first = machine.now();
    }
  }
  EXPECT_EQ(read_vcd(read_text(folder.file("v"))).end, first);
}

}  // namespace
}  // namespace gicube::emu
