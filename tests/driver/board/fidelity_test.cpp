// The report of fidelity levels, held against what a board did and what the documents say.
#include "gicube/fidelity.h"

#include <regex>

#include "gicube/fidelity_levels.h"
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

std::string levels_of(unsigned bits) {
  if (bits == kAtEveryLevel) return "all";
  std::string text;
  for (const Fidelity level : {Fidelity::kFunctional, Fidelity::kCycle}) {
    if ((bits >> static_cast<unsigned>(level) & 1) == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(name_of(level));
  }
  return text;
}

TEST(FidelityReport, HasTheTableOfTheHardwarePage) {
  std::string expected = "| not modelled | at levels |\n|---|---|\n";
  for (const LeftOut& each : kLeftOut) {
    expected += "| " + std::string(each.what) + " | " + levels_of(each.levels) + " |\n";
  }
  EXPECT_NE(text_of(GICUBE_SOURCE_DIR "/docs/reference/hardware.md").find(expected + '\n'), std::string::npos)
      << expected;
}

TEST(FidelityReport, HasTheCommandsOfItsWindowAlone) {
  Board board = Board::open("emu:?fidelity=cycle");
  board.set_transfer_function(step_function(0.5));
  EXPECT_TRUE(fidelity_report(board.counters()).empty());
  board.load_volume(BoxVolume(16, 4, 12).view());
  board.render(front_view(16));
  board.render(front_view(16));
  const Counters before = board.counters();
  board.render(front_view(16));
  for (const auto& [window, renders] : {std::pair{board.counters(), 3u}, std::pair{board.counters() - before, 1u}}) {
    const std::vector<LevelReport> report = fidelity_report(window);
    ASSERT_EQ(report.size(), 1u);
    EXPECT_EQ(report[0].level, Fidelity::kCycle);
    ASSERT_EQ(report[0].answered.size(), 1u);
    EXPECT_EQ(report[0].answered[0].command, "render");
    EXPECT_EQ(report[0].answered[0].count, renders);
    EXPECT_FALSE(report[0].not_modelled.empty());
  }
}

TEST(FidelityReport, TakesTheCountersOfABoardThatDoesNotTellCommands) {
  const std::vector<LevelReport> report = fidelity_report(Counters({{"fidelity_answered.functional", "command", 3}}));
  ASSERT_EQ(report.size(), 1u);
  EXPECT_EQ(report[0].answered.at(0).command, "");
  EXPECT_EQ(report[0].answered.at(0).count, 3u);
}

}  // namespace
}  // namespace gicube
