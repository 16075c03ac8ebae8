// A whole board under observation: what its files say against its counters, and that they change nothing.
#include "config/config.h"
#include "full_disk.h"
#include "observe/observation.h"
#include "observed_scene.h"
#include "read_trace.h"
#include "read_vcd.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

// A picture, its pixels, four traced rays, and a second picture without waiting for the first.
std::vector<wire::Pixel> session(BareBoard& board) {
  board.load_volume(kObservedSize, observed_voxel);
  board.write_segmentation([](unsigned, unsigned density) { return observed_material(density); });
  const wire::RenderCommand view = corner_view(kObservedSize, 16);
  board.render(view);
  std::vector<wire::Ray> rays;
  for (unsigned i = 0; i < 4; ++i) rays.push_back(host_ray(i, {2.0 + 4 * i, 9, 0.5}, {0, 0, 1}));
  board.command(BareBoard::trace_payload(rays));
  return board.render(view);
}

ReadTrace trace_of(const v1::BoardConfig& config, std::vector<wire::Counter>& counters) {
  const reference::TemporaryDirectory folder;
  {
    Observation observation({folder.file("t"), "", {}});
    BareBoard board(config, &observation);
    session(board);
    counters = board.counters();
  }
  return read_trace(read_text(folder.file("t")));
}

std::uint64_t value(const std::vector<wire::Counter>& counters, const std::string& name) {
  for (const wire::Counter& counter : counters) {
    if (counter.name == name) return counter.value;
  }
  throw std::runtime_error("no counter " + name);
}

v1::BoardConfig functional_config() {
  v1::BoardConfig config = observed_config();
  config.set_fidelity(v1::functional);
  return config;
}

TEST(BoardObservation, BusBytesAndTransfersAreTheCounters) {
  for (const v1::BoardConfig& config : {functional_config(), observed_config()}) {
    std::vector<wire::Counter> counters;
    const ReadTrace trace = trace_of(config, counters);
    const std::string down = "host bus/down, to the board", up = "host bus/up, to the host";
    EXPECT_EQ(trace.sum(down, "bytes"), value(counters, "bus.down.bytes"));
    EXPECT_EQ(trace.sum(up, "bytes"), value(counters, "bus.up.bytes"));
    EXPECT_EQ(trace.slices.at(down).size(), value(counters, "bus.down.transfers"));
    EXPECT_EQ(trace.slices.at(up).size(), value(counters, "bus.up.transfers"));
    std::uint64_t volume = 0;
    for (const ReadSlice& slice : trace.slices.at(down)) {
      if (slice.name == "volume") volume += slice.args.at("bytes").get<std::uint64_t>();
    }
    EXPECT_EQ(volume, value(counters, "bus.volume.bytes"));
  }
}

TEST(BoardObservation, CommandsAreTheDspsTurns) {
  std::vector<wire::Counter> counters;
  const ReadTrace trace = trace_of(observed_config(), counters);
  std::vector<std::string> names;
  for (const ReadSlice& slice : trace.slices.at("DSP/commands")) names.push_back(slice.name);
  EXPECT_THAT(names, ElementsAre("render", "trace", "render"));
  EXPECT_EQ(trace.sum("DSP/commands", "core_cycles"), value(counters, "asic.cycles"));
  EXPECT_EQ(trace.sum("DSP/commands", "dsp_cycles"), value(counters, "dsp.busy_cycles"));
  EXPECT_FALSE(trace.slices.at("host/waits for the board").empty());
}

TEST(BoardObservation, TheMachinesCyclesLieWithinTheirCommands) {
  std::vector<wire::Counter> counters;
  const ReadTrace trace = trace_of(observed_config(), counters);
  const auto& commands = trace.slices.at("DSP/commands");
  for (int processor = 0; processor < 3; ++processor) {
    const auto& slices = trace.slices.at("processor " + std::to_string(processor) + "/pipeline");
    std::size_t at = 0;
    for (const ReadSlice& command : commands) {
      ASSERT_LT(at, slices.size());
      EXPECT_EQ(slices[at].begin_ns, command.begin_ns);
      while (at < slices.size() && slices[at].end_ns <= command.end_ns) ++at;
      EXPECT_EQ(slices[at - 1].end_ns, command.begin_ns + command.args.at("core_cycles").get<std::int64_t>() * 10);
    }
    EXPECT_EQ(at, slices.size());
  }
}

TEST(BoardObservation, TimeGoesOnOverAReset) {
  const reference::TemporaryDirectory folder;
  {
    Observation observation({folder.file("t"), "", {}});
    std::uint64_t bytes = 0;
    for (int i = 0; i < 3; ++i) {
      BareBoard board(observed_config(), &observation);
      // What came before a power-up is on disk, whole.
      EXPECT_EQ(read_trace(read_text(folder.file("t"))).sum("host bus/down, to the board", "bytes"), bytes);
      session(board);
      bytes += board.counter("bus.down.bytes");
    }
  }
  const ReadTrace trace = read_trace(read_text(folder.file("t")));  // throws if tracks overlap
  const auto& power_ups = trace.instants.at("power-up");
  ASSERT_EQ(power_ups.size(), 3u);
  EXPECT_EQ(power_ups[0], 0);
  EXPECT_GT(power_ups[1], 0);
  EXPECT_NEAR(static_cast<double>(power_ups[2]), 2.0 * static_cast<double>(power_ups[1]), 1);
  EXPECT_EQ(trace.slices.at("DSP/commands").size(), 9u);
}

TEST(BoardObservation, RefusedAndCancelledCommandsLeaveAReadableTrace) {
  const reference::TemporaryDirectory folder;
  {
    Observation observation({folder.file("t"), folder.file("v"), {0, 100}});
    BareBoard board(observed_config(), &observation);
    board.wait(board.command({1, 2, 3}));
    board.load_volume(kObservedSize, observed_voxel);
    board.work.cancel = true;
    const auto payload = wire::encoded(corner_view(kObservedSize, 64));
    EXPECT_EQ(board.wait(board.command(payload)).completions.at(0).error, wire::ErrorCode::kCancelled);
    board.work.cancel = false;
    board.render(corner_view(kObservedSize, 8));
  }
  const ReadTrace trace = read_trace(read_text(folder.file("t")));
  EXPECT_EQ(trace.slices.at("DSP/commands").size(), 1u);
  EXPECT_EQ(read_vcd(read_text(folder.file("v"))).end, 100u);
}

TEST(BoardObservation, ChangesNoBitNoCycleAndNoCounter) {
  const reference::TemporaryDirectory folder;
  Observation observation({folder.file("t"), folder.file("v"), {100, 2000}});
  BareBoard plain(observed_config()), observed(observed_config(), &observation);
  EXPECT_EQ(session(plain), session(observed));
  EXPECT_EQ(plain.now_ps, observed.now_ps);
  EXPECT_EQ(plain.counters(), observed.counters());
}

// Becomes interested when it has been asked so often, and sees every cycle from then on.
class LateObserver final : public BoardObserver, public Observer {
 public:
  explicit LateObserver(int asked) : left_(asked) {}

  Observer* observer() override { return this; }
  void transferred(const BusDelivery& /*delivery*/) override {}
  void served(const BusTransaction& /*transaction*/, Picoseconds /*begin*/, Picoseconds /*end*/) override {}
  bool is_interested() const override { return left_ == 0 || --left_ == 0; }
  void see(Cycle now, const Machine& /*machine*/) override {
    EXPECT_TRUE(seen_ == 0 || now >= latest_) << now;
    latest_ = now;
    ++seen_;
  }
  bool watches(std::uint64_t /*ray*/, const wire::Ray& /*made*/) override { return true; }
  void happened(const RayEvent& /*event*/, const Machine& /*machine*/) override { ++events_; }

  std::uint64_t seen() const { return seen_; }
  std::uint64_t events() const { return events_; }

 private:
  mutable int left_;
  std::uint64_t seen_ = 0, events_ = 0;
  Cycle latest_ = 0;
};

// The machine that ticks every part is the reference; the others compute ahead until the observer wants to see.
TEST(BoardObservation, AnObserverWhoComesLateChangesNoBitNoCycleAndNoCounter) {
  const auto big_session = [](BareBoard& board) {
    session(board);
    return board.render(corner_view(kObservedSize, 96));
  };
  for (const char* policy : {"sorter.policy=most_rays", "sorter.policy=most_contribution"}) {
    LateObserver from_begin(1);
    BareBoard ticked(observed_config({policy}), &from_begin);
    const std::vector<wire::Pixel> image = big_session(ticked);
    EXPECT_EQ(ticked.cycles_ahead(), 0u);
    BareBoard fast(observed_config({policy}));
    EXPECT_EQ(big_session(fast), image);
    EXPECT_EQ(fast.counters(), ticked.counters());
    EXPECT_GT(fast.cycles_ahead(), 0u);
    std::uint64_t before = 0;
    for (const int asked : {6, 9, 14, 20}) {
      LateObserver late(asked);
      BareBoard board(observed_config({policy}), &late);
      EXPECT_EQ(big_session(board), image) << asked;
      EXPECT_EQ(board.now_ps, ticked.now_ps) << asked;
      EXPECT_EQ(board.counters(), ticked.counters()) << asked;
      EXPECT_GT(late.seen(), 0u) << asked;
      EXPECT_LT(late.seen(), from_begin.seen()) << asked;
      EXPECT_LT(late.events(), from_begin.events()) << asked;
      EXPECT_GE(board.cycles_ahead(), before) << asked;
      EXPECT_LT(board.cycles_ahead(), fast.cycles_ahead()) << asked;
      before = board.cycles_ahead();
    }
  }
}

TEST(BoardObservation, AFunctionalBoardShowsBusAndDsp) {
  std::vector<wire::Counter> counters;
  const ReadTrace trace = trace_of(functional_config(), counters);
  EXPECT_EQ(trace.sum("DSP/commands", "core_cycles"), 0u);
  EXPECT_EQ(trace.slices.count("processor 0/pipeline"), 0u);
}

TEST(BoardObservation, NamesTheFileThatCannotBeOpened) {
  EXPECT_THROW(Observation({"/nowhere/t", "", {}}), std::runtime_error);
  EXPECT_THROW(Observation({"", "/nowhere/v", {0, 1}}), std::runtime_error);
}

TEST(BoardObservation, TellsThatTheDiskIsFull) {
  Observation observation({"/dev/full", "", {}});
  BareBoard board(functional_config(), &observation);
  EXPECT_THAT(observation.fault(), HasSubstr("/dev/full"));
}

// What was written of it would end in the middle of a record.
TEST(BoardObservation, LeavesNoFileOnAFullDisk) {
  reference::on_full_disks("b", reference::kDiskBlock, [](const std::string& folder, const std::string&) {
    for (const char* name : {"t", "v"}) {
      const std::string file = folder + "/" + name;
      const bool trace = *name == 't';
      Observation observation({trace ? file : "", trace ? "" : file, {0, 2000}});
      BareBoard board(observed_config(), &observation);
      session(board);
      observation.power_up(observed_config());  // as when a client leaves
      EXPECT_EQ(observation.fault(), "expected to write all of " + file + ", but a write failed");
      EXPECT_EQ(reference::files_in(folder).size(), 1u);
    }
  });
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

TEST(BoardObservation, FurtherBoardsWriteFilesWithTheirNumber) {
  const ObservationOptions options{"a.json", "", {3, 4}};
  EXPECT_EQ(for_board(options, 0).trace_file, "a.json");
  EXPECT_EQ(for_board(options, 2).trace_file, "a.json.2");
  EXPECT_EQ(for_board(options, 2).vcd_file, "");
  EXPECT_EQ(for_board({"", "v", {3, 4}}, 5).vcd_file, "v.5");
}

}  // namespace
}  // namespace gicube::emu
