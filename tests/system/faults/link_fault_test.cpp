// The driver's error for each kind of fault; the application continues after it.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <optional>

#include "board_process.h"
#include "good_client.h"
#include "temporary_directory.h"

namespace gicube::system_test {
namespace {

using namespace std::chrono_literals;

enum class Interaction { kNothing, kTimedOut, kClosed, kCorrupted, kCorruptedOrTimedOut, kMemoryFault };

struct Case {
  std::string name;
  std::string fault;  // all but its message
  Interaction met;

  friend void PrintTo(const Case& each, std::ostream* out) { *out << each.name; }
};

class LinkFault : public testing::TestWithParam<Case> {
 protected:
  // A board on which the `message`-th message meets the fault; 0: none does.
  void start(int message) {
    std::ofstream plan(folder.file("plan"));
    if (message > 0) plan << "fault { message: " << message << ' ' << GetParam().fault << " }";
    plan.close();
    std::vector<std::string> arguments = small_board();
    arguments.insert(arguments.end(), {"--listen", uri(), "--faults", folder.file("plan")});
    process.emplace(arguments);
    ASSERT_FALSE(process->read_line().empty()) << process->read_errors();
  }
  std::string uri() const { return "unix:" + folder.file("board"); }

  Board open(int reopen_attempts) const {
    OpenOptions options;
    options.watchdog = 1s;
    options.keep_volume = true;
    options.reopen_attempts = reopen_attempts;
    return Board::open(uri(), options);
  }

  // What the call throws.
  template <typename Call>
  static Interaction interact(const Call& call) {
    try {
      call();
    } catch (const TimedOut&) {
      return Interaction::kTimedOut;
    } catch (const MemoryFault&) {
      return Interaction::kMemoryFault;
    } catch (const DeviceLost& lost) {
      if (lost.cause() == Loss::kCorrupted) return Interaction::kCorrupted;
      if (lost.cause() == Loss::kClosed) return Interaction::kClosed;
      throw;
    }
    return Interaction::kNothing;
  }

  const reference::TemporaryDirectory folder;
  std::optional<BoardProcess> process;
};

// At some of the messages of opening, loading and working; the last ones there are only on the way down.
constexpr int kMessages[] = {1, 5, 17, 19, 22, 25, 28, 31, 40, 59, 66, 71};
constexpr int kWorking = 18;  // from about here on commands are under way

TEST_P(LinkFault, IsItsTypedErrorAndReopeningGoesOn) {
  start(0);
  std::optional<Board> board(open(0));
  prepare(*board);
  const Round expected = work(*board);
  int met = 0;
  for (const int message : kMessages) {
    board.reset();
    start(message);
    bool opened = false, prepared = false;
    const auto everything = [&] {
      board.emplace(open(0));
      opened = true;
      prepare(*board);
      prepared = true;
      work(*board);
    };
    Interaction how = Interaction::kNothing;
    try {
      how = interact(everything);
    } catch (const OpenFailed&) {
      EXPECT_FALSE(opened) << message;
      continue;  // so early that there is no board to reopen
    }
    if (how == Interaction::kNothing && message > kWorking) continue;  // there were not so many
    const Interaction wanted = GetParam().met;
    if (wanted == Interaction::kMemoryFault && message < kWorking) continue;  // forgotten with the reset at opening
    if (wanted == Interaction::kCorruptedOrTimedOut) {
      EXPECT_TRUE(how == Interaction::kCorrupted || how == Interaction::kTimedOut) << message;
    } else {
      EXPECT_EQ(how, wanted) << message;
    }
    if (!opened) continue;
    ++met;
    if (how != Interaction::kNothing && how != Interaction::kMemoryFault) {
      if (GetParam().name == "kill") {
        EXPECT_EQ(process->exit_code(), 128 + SIGKILL);
        start(0);
      }
      const Reopened reopened = board->reopen();
      if (!reopened.volume) prepared = false;
    }
    if (!prepared) prepare(*board);
    EXPECT_EQ(work(*board).pictures, expected.pictures) << message;
  }
  EXPECT_GE(met, 3);
}

TEST_P(LinkFault, IsNotNoticedByAnApplicationThatLetsTheDriverResume) {
  if (GetParam().met == Interaction::kMemoryFault || GetParam().name == "kill")
    GTEST_SKIP() << "the link can't mend that";
  start(0);
  std::optional<Board> board(open(0));
  prepare(*board);
  const Round expected = work(*board);
  for (const int message : kMessages) {
    board.reset();
    start(message);
    board.emplace(open(5));
    prepare(*board);
    EXPECT_EQ(work(*board), expected) << message;  // simulated times too
  }
}

INSTANTIATE_TEST_SUITE_P(
    EveryKind, LinkFault,
    testing::Values(Case{"drop_down", "direction: down kind: drop", Interaction::kCorruptedOrTimedOut},
                    Case{"drop_up", "direction: up kind: drop", Interaction::kCorruptedOrTimedOut},
                    Case{"delay_down", "direction: down kind: delay delay_ms: 30", Interaction::kNothing},
                    Case{"delay_up", "direction: up kind: delay delay_ms: 30", Interaction::kNothing},
                    Case{"corrupt_down", "direction: down kind: corrupt bit: 99", Interaction::kCorrupted},
                    Case{"corrupt_up", "direction: up kind: corrupt bit: 99", Interaction::kCorrupted},
                    Case{"duplicate_down", "direction: down kind: duplicate", Interaction::kNothing},
                    Case{"duplicate_up", "direction: up kind: duplicate", Interaction::kNothing},
                    Case{"hang_down", "direction: down kind: hang", Interaction::kTimedOut},
                    Case{"hang_up", "direction: up kind: hang", Interaction::kTimedOut},
                    Case{"link_loss_down", "direction: down kind: link_loss", Interaction::kClosed},
                    Case{"link_loss_up", "direction: up kind: link_loss", Interaction::kClosed},
                    Case{"kill", "direction: down kind: kill", Interaction::kClosed},
                    Case{"slow", "direction: up kind: slow bytes_per_second: 100000 messages: 3",
                         Interaction::kNothing},
                    Case{"memory_detected", "direction: down kind: memory_detected", Interaction::kMemoryFault}),
    [](const testing::TestParamInfo<Case>& each) { return each.param.name; });

}  // namespace
}  // namespace gicube::system_test
