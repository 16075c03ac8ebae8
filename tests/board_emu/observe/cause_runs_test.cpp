#include "observe/cause_runs.h"

#include "test.h"

namespace gicube::emu {
namespace {

std::vector<CauseSlice> join(const std::vector<Cause>& causes, Cycle first = 100) {
  std::vector<CauseSlice> slices;
  const auto emit = [&slices](const CauseSlice& slice) { slices.push_back(slice); };
  CauseRuns runs;
  runs.start(first);
  for (std::size_t i = 0; i < causes.size(); ++i) runs.add(first + i, causes[i], emit);
  runs.finish(first + causes.size(), emit);
  return slices;
}

std::uint64_t count(const CauseSlice& slice, Cause cause) { return slice.counts[static_cast<std::size_t>(cause)]; }

void append(std::vector<Cause>& causes, std::size_t cycles, Cause cause) {
  for (std::size_t i = 0; i < cycles; ++i) causes.push_back(cause);
}

TEST(CauseRuns, ALongRunIsASliceOfItsOwn) {
  std::vector<Cause> causes;
  append(causes, CauseRuns::kLongRun, Cause::kMiss);
  append(causes, 30, Cause::kBusy);
  const auto slices = join(causes);
  ASSERT_EQ(slices.size(), 2u);
  EXPECT_EQ(slices[0].cause(), Cause::kMiss);
  EXPECT_EQ(slices[0].begin, 100u);
  EXPECT_EQ(slices[0].end, 108u);
  EXPECT_EQ(slices[1].cause(), Cause::kBusy);
  EXPECT_EQ(slices[1].end, 138u);
}

TEST(CauseRuns, ShortRunsShareASliceNamedAfterTheMostFrequent) {
  std::vector<Cause> causes;
  append(causes, 10, Cause::kDsp);
  append(causes, 3, Cause::kBusy);
  append(causes, 7, Cause::kMiss);
  append(causes, 3, Cause::kBusy);
  append(causes, 2, Cause::kFill);
  append(causes, 4, Cause::kBusy);
  append(causes, 20, Cause::kQueueEmpty);
  const auto slices = join(causes);
  ASSERT_EQ(slices.size(), 3u);
  EXPECT_EQ(slices[1].cause(), Cause::kBusy);
  EXPECT_EQ(slices[1].begin, 110u);
  EXPECT_EQ(slices[1].end, 129u);
  EXPECT_EQ(count(slices[1], Cause::kBusy), 10u);
  EXPECT_EQ(count(slices[1], Cause::kMiss), 7u);
  EXPECT_EQ(count(slices[1], Cause::kFill), 2u);
  EXPECT_EQ(slices[2].cause(), Cause::kQueueEmpty);
}

TEST(CauseRuns, AShortInterruptionDoesNotCutASlice) {
  std::vector<Cause> causes;
  append(causes, 20, Cause::kBusy);
  append(causes, 1, Cause::kFill);
  append(causes, 2, Cause::kMiss);
  append(causes, 30, Cause::kBusy);
  append(causes, 3, Cause::kSorter);
  append(causes, 9, Cause::kDsp);
  const auto slices = join(causes);
  ASSERT_EQ(slices.size(), 2u);
  EXPECT_EQ(slices[0].cause(), Cause::kBusy);
  EXPECT_EQ(slices[0].end, 156u);
  EXPECT_EQ(count(slices[0], Cause::kSorter), 3u);
  EXPECT_EQ(count(slices[1], Cause::kDsp), 9u);
}

TEST(CauseRuns, AStretchOfShortRunsIsCutSoThatItCanBeRead) {
  std::vector<Cause> causes;
  for (int i = 0; i < 100; ++i) {
    append(causes, 3, Cause::kBusy);
    append(causes, 1, Cause::kFill);
  }
  const auto slices = join(causes);
  ASSERT_EQ(slices.size(), 7u);
  EXPECT_EQ(slices[0].end - slices[0].begin, CauseRuns::kMixed);
  EXPECT_EQ(count(slices[0], Cause::kFill), CauseRuns::kMixed / 4);
}

TEST(CauseRuns, EveryCycleIsInOneSliceAndSlicesTouch) {
  std::mt19937 engine(5);
  for (int round = 0; round < 200; ++round) {
    std::vector<Cause> causes;
    CauseCounts expected{};
    for (auto left = engine() % 40; left > 0; --left) {
      const auto cause = static_cast<Cause>(engine() % kCauses);
      const auto cycles = 1 + engine() % (engine() % 4 == 0 ? 60 : 9);
      append(causes, cycles, cause);
      expected[static_cast<std::size_t>(cause)] += cycles;
    }
    CauseCounts counts{};
    Cycle end = 100;
    for (const CauseSlice& slice : join(causes)) {
      EXPECT_EQ(slice.begin, end);
      EXPECT_EQ(std::accumulate(slice.counts.begin(), slice.counts.end(), Cycle{0}), slice.end - slice.begin);
      end = slice.end;
      for (std::size_t i = 0; i < kCauses; ++i) counts[i] += slice.counts[i];
    }
    EXPECT_EQ(end, 100 + causes.size());
    EXPECT_EQ(counts, expected);
  }
}

}  // namespace
}  // namespace gicube::emu
