// The report of fidelity levels, held against what a board did and what the documents say.
#include "gicube/fidelity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "gicube/fidelity_levels.h"
#include "test_board.h"

namespace gicube {
namespace {

std::string page(std::string_view name) {
  std::ifstream file(GICUBE_SOURCE_DIR "/" + std::string(name));
  EXPECT_TRUE(file) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string levels_of(unsigned bits) {
  if (bits == kAtEveryLevel) return "all";
  std::string text;
  for (const Fidelity level : {Fidelity::kFunctional, Fidelity::kApproximate, Fidelity::kCycle}) {
    if ((bits >> static_cast<unsigned>(level) & 1) == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(name_of(level));
  }
  return text;
}

TEST(FidelityReport, HasTheTableOfTheHardwarePage) {
  std::string expected = "| not modelled | at levels |\n| --- | --- |\n";
  for (const LeftOut& each : kLeftOut) {
    expected += "| " + std::string(each.what) + " | " + levels_of(each.levels) + " |\n";
  }
  EXPECT_NE(page("docs/reference/hardware.md").find(expected + '\n'), std::string::npos) << expected;
}

TEST(FidelityReport, StatesErrorsThatItsSourcesState) {
  for (const MeasuredError& each : kApproximateErrors) {
    char text[32];
    std::snprintf(text, sizeof text, each.is_relative ? "%g%%" : "within %g",
                  each.within * (each.is_relative ? 100 : 1));
    EXPECT_NE(page(each.source).find(text), std::string::npos) << each.source << " has no " << text;
  }
}

// A picture of a volume that is larger than the card is left to the cycle level.
class TwoLevels : public testing::Test {
 protected:
  TwoLevels()
      : board_(open_board("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32&set=asic.processors=3&"
                          "fidelity=approximate")) {
    board_.set_transfer_function(reference::step_function(0.5));
  }

  void render(int edge) {
    board_.load_volume(reference::BoxVolume(edge, edge / 4, 3 * edge / 4).view());
    board_.render(reference::front_view(16));
  }

  Board board_;
};

TEST_F(TwoLevels, AreReportedWithTheCommandsThatEachAnswered) {
  EXPECT_TRUE(fidelity_report(board_.counters()).empty());
  render(16);
  render(16);
  const Counters before = board_.counters();
  render(40);
  const std::vector<LevelReport> all = fidelity_report(board_.counters());
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].level, Fidelity::kApproximate);
  ASSERT_EQ(all[0].answered.size(), 1u);
  EXPECT_EQ(all[0].answered[0].command, "render");
  EXPECT_EQ(all[0].answered[0].count, 2u);
  EXPECT_EQ(all[0].estimates.size(), kApproximateErrors.size());
  EXPECT_EQ(all[1].level, Fidelity::kCycle);
  EXPECT_EQ(all[1].answered.at(0).command, "render");
  EXPECT_TRUE(all[1].estimates.empty());
  EXPECT_LT(all[1].not_modelled.size(), all[0].not_modelled.size());

  const std::vector<LevelReport> later = fidelity_report(board_.counters() - before);
  ASSERT_EQ(later.size(), 1u);  // a window has what happened in it alone
  EXPECT_EQ(later[0].level, Fidelity::kCycle);
}

// Shares of all cycles can be formed whichever levels have answered: what has no cause is counted as such.
TEST_F(TwoLevels, CountCyclesThatAddUpByCause) {
  const auto of_all_causes = [this] {
    std::uint64_t sum = 0;
    const Counters counters = board_.counters();
    for (const Counter& counter : counters.list()) {
      if (counter.name.starts_with("processor.cycles.")) sum += counter.value;
    }
    return sum;
  };
  const auto value = [this](const char* name) { return board_.counters().value(name); };
  render(16);
  const std::uint64_t unattributed = value("processor.cycles.unattributed");
  EXPECT_GT(unattributed, 0u);
  EXPECT_EQ(of_all_causes(), 3 * value("asic.cycles"));
  render(40);
  EXPECT_GT(value("processor.cycles.latency"), 0u);
  EXPECT_EQ(value("processor.cycles.unattributed"), unattributed) << "the cycle level knows all its causes";
  EXPECT_EQ(of_all_causes(), 3 * value("asic.cycles"));
}

TEST(FidelityReport, TakesTheCountersOfABoardThatDoesNotTellCommands) {
  const std::vector<LevelReport> report = fidelity_report(Counters({{"fidelity_answered.functional", "command", 3}}));
  ASSERT_EQ(report.size(), 1u);
  EXPECT_EQ(report[0].answered.at(0).command, "");
  EXPECT_EQ(report[0].answered.at(0).count, 3u);
}

}  // namespace
}  // namespace gicube
