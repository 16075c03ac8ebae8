#include "scene/program/bounds.h"

#include <fstream>
#include <string>

#include "test.h"

namespace gicube::samples {
namespace {

// A frame of 10 ms on a board of 100 MHz with two processors.
constexpr Picoseconds kFrame = 10'000'000'000;
BoardInfo board() {
  BoardInfo info;
  info.core_khz = 100'000;
  info.processors = 2;
  return info;
}

Counters counters(std::initializer_list<std::pair<const char*, std::uint64_t>> values) {
  std::vector<Counter> list;
  for (const auto& [name, value] : values) list.push_back({name, "", value});
  return Counters(std::move(list));
}

TEST(WhatBounds, IsTheBusIfItIsBusierThanTheAsic) {
  // 6 ms of transfers, 4 ms of the ASIC: 400,000 cycles, 800,000 of both pipelines.
  const std::string text = what_bounds(kFrame,
                                       counters({{"bus.down.busy_ps", 5'000'000'000},
                                                 {"bus.up.busy_ps", 1'000'000'000},
                                                 {"asic.cycles", 400'000},
                                                 {"processor.cycles.busy", 600'000},
                                                 {"processor.cycles.queue_empty", 200'000}}),
                                       board());
  EXPECT_EQ(text,
            "bounded by the host bus; bus 60%, ASIC 40%, DSP 0% of the time; 75% of the pipelines' cycles take "
            "samples, 25% have no ray, "
            "as others have them");
}

TEST(WhatBounds, IsTheLargestCauseOfThePipelinesCycles) {
  const auto bounded_by = [](const char* cause) {
    return what_bounds(
        kFrame, counters({{"asic.cycles", 900'000}, {"processor.cycles.busy", 500'000}, {cause, 1'300'000}}), board());
  };
  EXPECT_THAT(bounded_by("processor.cycles.leap"),
              StartsWith("bounded by the pipelines: 72% of the pipelines' cycles skip"));
  EXPECT_THAT(bounded_by("processor.cycles.link"), StartsWith("bounded by the links: 72%"));
  EXPECT_THAT(bounded_by("processor.cycles.queue_empty"), StartsWith("bounded by idle processors: 72%"));
  EXPECT_THAT(bounded_by("processor.cycles.sdram"), StartsWith("bounded by the DSP: 72%"));
  EXPECT_THAT(bounded_by("processor.cycles.memory_bank"), StartsWith("bounded by the memory: 72%"));
  EXPECT_THAT(bounded_by("processor.cycles.cache_miss"), HasSubstr("28% take samples; bus 0%, ASIC 90%"));
}

TEST(WhatBounds, IsThePartThatTheHardwaresPageNames) {
  std::ifstream file(GICUBE_SOURCE_DIR "/docs/reference/hardware/causes.csv");
  std::string line;
  std::getline(file, line);
  int causes = 0;
  for (; std::getline(file, line); ++causes) {
    const std::string cause = "processor.cycles." + line.substr(0, line.find(','));
    const std::string part = line.substr(line.rfind(',') + 1);
    EXPECT_THAT(what_bounds(kFrame, counters({{"asic.cycles", 900'000}, {cause.c_str(), 1}}), board()),
                StartsWith("bounded by " + part + ": 100% of the pipelines' cycles"));
  }
  EXPECT_EQ(causes, 14);
}

TEST(WhatBounds, AddsCausesOfOnePart) {
  EXPECT_THAT(what_bounds(kFrame,
                          counters({{"asic.cycles", 900'000},
                                    {"processor.cycles.busy", 400'000},
                                    {"processor.cycles.dsp_compute", 300'000},
                                    {"processor.cycles.sdram", 300'000}}),
                          board()),
              StartsWith("bounded by the DSP: 60%"));
}

TEST(WhatBounds, IsBusOrDspWhereTheAsicHasNoTime) {
  EXPECT_THAT(
      what_bounds(kFrame, counters({{"bus.up.busy_ps", 9'000'000'000}, {"dsp.busy_ps", 1'000'000'000}}), board()),
      StartsWith("bounded by the host bus, busy 90% of the time"));
  EXPECT_THAT(
      what_bounds(kFrame, counters({{"bus.up.busy_ps", 1'000'000'000}, {"dsp.busy_ps", 8'000'000'000}}), board()),
      StartsWith("bounded by the DSP, busy 80% of the time"));
  EXPECT_EQ(what_bounds(0, Counters(), board()), "");
}

TEST(WhatBounds, TakesTheMeanOfSeveralBoards) {
  EXPECT_THAT(what_bounds(kFrame, counters({{"bus.up.busy_ps", 10'000'000'000}}), board(), 2), HasSubstr("busy 50%"));
}

}  // namespace
}  // namespace gicube::samples
