// The slot is where sessions and management meet: no gRPC here, so that ThreadSanitizer sees every access.
#include "server/bus/board_slot.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>
#include <new>

#include "served_boards.h"
#include "test.h"

namespace {
std::atomic<std::time_t> clock_was_set_by = 0;  // seconds
}

// In place of the C library's: somebody sets the machine's clock.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const auto result = static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
  if (clock == CLOCK_REALTIME) time->tv_sec += clock_was_set_by;
  return result;
}

namespace gicube::emu {
namespace {

Claimant nobody() {
  return {.end_session = [](wire::ErrorCode, const std::string&) {}};
}

// No board can be built while `fails` is set.
class PoorSlot : public BoardSlot {
 public:
  using BoardSlot::BoardSlot;

  std::atomic<bool> fails{false};

 private:
  std::unique_ptr<Board> build(const v1::BoardConfig& config, Observation* observation) const override {
    if (fails) throw std::bad_alloc();
    return BoardSlot::build(config, observation);
  }
};

// Calls `asked` while it builds a board.
class AskedSlot : public BoardSlot {
 public:
  using BoardSlot::BoardSlot;

  std::function<void()> asked;

 private:
  std::unique_ptr<Board> build(const v1::BoardConfig& config, Observation* observation) const override {
    asked();
    return BoardSlot::build(config, observation);
  }
};

TEST(BoardSlot, HasOneOwnerAtATime) {
  BoardSlot slot(3, {});
  EXPECT_EQ(slot.claim(nobody()), Claim::kGranted);
  EXPECT_EQ(slot.claim(nobody()), Claim::kBusy);
  EXPECT_TRUE(slot.info().in_use);
  slot.announce_release();
  EXPECT_EQ(slot.claim(nobody()), Claim::kSoonFree);
  slot.release();
  EXPECT_FALSE(slot.info().in_use);
  EXPECT_EQ(slot.claim(nobody()), Claim::kGranted);
  slot.release();
}

TEST(BoardSlot, SaysHowLongItHasHadItsOwnerWhateverTheClockIsSetTo) {
  BoardSlot slot(0, {});
  Claimant who = nobody();
  who.name = "process 7";
  ASSERT_EQ(slot.claim(who), Claim::kGranted);
  for (const std::time_t jump : {-945'993'598, 945'993'598}) {
    const auto before = std::chrono::system_clock::now();
    clock_was_set_by = jump;
    EXPECT_NEAR(std::chrono::duration<double>(std::chrono::system_clock::now() - before).count(),
                static_cast<double>(jump), 60);
    EXPECT_THAT(slot.owner(), testing::MatchesRegex("process 7 since .* UTC, [0-9]+ s ago"));
    EXPECT_LT(slot.owner().size(), sizeof "process 7 since 2026-01-01 00:00:00 UTC, 100 s ago");
    clock_was_set_by = 0;
  }
  slot.release();
}

TEST(BoardSlot, APowerResetAsksTheOwnerToEndAndWaitsForIt) {
  BoardSlot slot(0, {});
  std::thread owner;
  ASSERT_EQ(slot.claim({.end_session = [&](wire::ErrorCode,
                                           const std::string&) { owner = std::thread([&slot] { slot.release(); }); }}),
            Claim::kGranted);
  std::string reason;
  EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kDone);
  EXPECT_FALSE(slot.info().in_use);
  owner.join();
}

TEST(BoardSlot, ABoardThatCannotBeBuiltAnewIsNobodysUntilItCan) {
  const reference::TemporaryDirectory folder;
  PoorSlot slot(0, {});
  BusServer server(patient());
  server.listen(slot, {EndpointKind::kUnix, folder.file("board"), "", 0, -1});
  std::thread serving([&server] { server.run(); });
  const auto connect = [&folder] { return reference::RawClient::connect_unix(folder.file("board")); };
  {
    reference::RawClient first = connect();
    ASSERT_EQ(first.handshake()->header.error, wire::ErrorCode::kNone);
    first.write_register(wire::reg::kVolumeX, 64);
    EXPECT_EQ(first.read_register(wire::reg::kVolumeX), 64u);
    slot.fails = true;
  }
  for (int i = 0; i < 2; ++i) {
    reference::RawClient refused = connect();
    const auto answer = refused.handshake();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->header.error, wire::ErrorCode::kInternal);
    EXPECT_THAT(answer->text(), HasSubstr("board 0: the system has no memory left for the board"));
    EXPECT_FALSE(slot.has_board());
    EXPECT_TRUE(slot.counters().counters.empty());
  }
  slot.fails = false;
  {
    reference::RawClient next = connect();
    ASSERT_EQ(next.handshake()->header.error, wire::ErrorCode::kNone);
    EXPECT_EQ(next.read_register(wire::reg::kVolumeX), 0u);
    EXPECT_EQ(next.read_register(wire::reg::kId), wire::kIdValue);
  }
  server.stop();
  serving.join();
}

TEST(BoardSlot, WhatManagementCannotBuildLeavesTheBoardAsItWas) {
  PoorSlot slot(0, {});
  slot.fails = true;
  std::string reason;
  EXPECT_EQ(slot.configure("asic { processors: 8 }", reason), BoardSlot::Configured::kFailed);
  EXPECT_THAT(reason, HasSubstr("no memory left"));
  EXPECT_TRUE(slot.has_board());
  EXPECT_EQ(slot.info().config.asic().processors(), 4u);
  EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kFailed);
  EXPECT_FALSE(slot.has_board());
  slot.fails = false;
  EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kDone);
  EXPECT_TRUE(slot.has_board());
}

TEST(BoardSlot, ACallThatNobodyWaitsForChangesNothing) {
  BoardSlot slot(0, {});
  std::string reason;
  const auto at_once = [] { return true; };
  EXPECT_EQ(slot.configure("asic { processors: 8 }", reason, at_once), BoardSlot::Configured::kCancelled);
  EXPECT_EQ(slot.info().config.asic().processors(), 4u);
  EXPECT_EQ(slot.set_trace_file("/nowhere/trace", reason, at_once), BoardSlot::Configured::kCancelled);
  // An owner that does not end, however it is asked.
  ASSERT_EQ(slot.claim(nobody()), Claim::kGranted);
  int asked = 0;
  EXPECT_EQ(slot.power_reset(reason, [&asked] { return ++asked > 3; }), BoardSlot::Configured::kCancelled);
  EXPECT_EQ(asked, 5);  // and once more for the answer
  slot.release();
  EXPECT_EQ(slot.configure("asic { processors: 8 }", reason), BoardSlot::Configured::kDone);
}

// At a free board too: who came first is waited for.
TEST(BoardSlot, GivesTheBoardToThoseInLineInItsOrder) {
  BoardSlot slot(0, {});
  const auto claims = [&slot](std::uint64_t place) {
    Claimant who = nobody();
    who.place = place;
    return slot.claim(who);
  };
  const std::uint64_t first = slot.enqueue(false), second = slot.enqueue(false);
  EXPECT_EQ(claims(0), Claim::kBusy);
  EXPECT_EQ(claims(second), Claim::kBusy);
  const std::uint64_t forced = slot.enqueue(true);
  EXPECT_EQ(claims(first), Claim::kBusy);
  for (const std::uint64_t place : {forced, first, second}) {
    EXPECT_EQ(claims(place), Claim::kGranted);
    slot.leave_queue(place);
    slot.release();
  }
  EXPECT_EQ(claims(0), Claim::kGranted);
}

TEST(BoardSlot, IsConfiguredWhileItHasNoOwner) {
  BoardSlot slot(0, {});
  std::string reason;
  EXPECT_EQ(slot.configure("asic { processors: 8 }", reason), BoardSlot::Configured::kDone);
  ASSERT_EQ(slot.claim(nobody()), Claim::kGranted) << "it is free again";
  EXPECT_EQ(slot.configure("asic { processors: 2 }", reason), BoardSlot::Configured::kInUse);
  EXPECT_EQ(slot.info().config.asic().processors(), 8u);
  EXPECT_EQ(slot.configure("asic { processors: 99 }", reason), BoardSlot::Configured::kFaulty);
  EXPECT_FALSE(reason.empty());
}

TEST(BoardSlot, ASessionWhoseClientIsAwayLetsGoForAConfiguration) {
  BoardSlot slot(0, {});
  std::thread owner;
  std::string told;
  const auto make_way = [&](wire::ErrorCode error, const std::string& text) {
    EXPECT_EQ(error, wire::ErrorCode::kCancelled);
    told = text;
    owner = std::thread([&slot] { slot.release(); });
  };
  ASSERT_EQ(slot.claim({.end_session = make_way}), Claim::kGranted);
  slot.set_away(true);
  std::string reason;
  EXPECT_EQ(slot.configure("asic { processors: 8 }", reason), BoardSlot::Configured::kDone);
  EXPECT_EQ(told, "the management plane has rebuilt the board");
  EXPECT_EQ(slot.info().config.asic().processors(), 8u);
  if (owner.joinable()) owner.join();
  EXPECT_EQ(slot.claim(nobody()), Claim::kGranted);
}

TEST(BoardSlot, WritesItsTraceFromANewBoardOnWhileItHasNoOwner) {
  const reference::TemporaryDirectory folder;
  AskedSlot slot(0, {});
  int built = 0;
  slot.asked = [&built] { ++built; };
  std::string reason;
  const Board* const former = &slot.board();
  EXPECT_EQ(slot.set_trace_file(folder.file("trace"), reason), BoardSlot::Configured::kDone);
  EXPECT_EQ(slot.trace_file(), folder.file("trace"));
  EXPECT_EQ(built, 1);
  EXPECT_NE(&slot.board(), former);
  ASSERT_EQ(slot.claim(nobody()), Claim::kGranted);
  EXPECT_EQ(slot.set_trace_file("", reason), BoardSlot::Configured::kInUse);
  EXPECT_EQ(slot.trace_file(), folder.file("trace"));
  slot.release();
  EXPECT_EQ(slot.set_trace_file("", reason), BoardSlot::Configured::kDone);
  EXPECT_EQ(slot.trace_file(), "");
}

TEST(BoardSlot, SaysWhichTraceFileItCouldNotWrite) {
  const reference::TemporaryDirectory folder;
  BoardSlot slot(0, {});
  std::string reason;
  EXPECT_EQ(slot.set_trace_file(folder.file("none/trace"), reason), BoardSlot::Configured::kFaulty);
  EXPECT_THAT(reason, HasSubstr(folder.file("none/trace")));
  EXPECT_EQ(slot.trace_file(), "");
}

// Some time of a claim meets some configuration or reset under way.
TEST(BoardSlot, IsTheManagementsWhileThatBuildsOrResetsTheBoard) {
  AskedSlot slot(0, {});
  std::vector<Claim> answers;
  slot.asked = [&] { answers.push_back(slot.claim(nobody())); };
  std::string reason;
  EXPECT_EQ(slot.configure("asic { processors: 8 }", reason), BoardSlot::Configured::kDone);
  EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kDone);
  EXPECT_THAT(answers, ElementsAre(Claim::kSoonFree, Claim::kSoonFree));
  EXPECT_EQ(slot.claim(nobody()), Claim::kGranted);
  slot.release();
}

TEST(BoardSlot, APowerResetClearsABoardWithoutAnOwner) {
  BoardSlot slot(0, {});
  Progress progress;
  const auto access = [&](wire::FrameType type, std::vector<std::uint32_t> words) {
    wire::FrameHeader header;
    header.type = type;
    header.time_ps = 1'000'000;
    std::vector<std::uint8_t> payload(4 * words.size());
    for (std::size_t i = 0; i < words.size(); ++i) wire::store(std::span(payload), 4 * i, words[i]);
    return slot.board().transact(header, payload, progress);
  };
  access(wire::FrameType::kRegisterWrite, {wire::reg::kVolumeX, 64});
  access(wire::FrameType::kRegisterRead, {wire::reg::kVolumeX});
  ASSERT_GT(slot.counters().simulated_ps, 0u);
  std::string reason;
  EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kDone);
  EXPECT_EQ(slot.counters().simulated_ps, 0u);
  const auto read = access(wire::FrameType::kRegisterRead, {wire::reg::kVolumeX});
  EXPECT_EQ(wire::load<std::uint32_t>(read.reply->payload, 0), 0u);
}

TEST(BoardSlot, APowerResetIsDoneThoughTheNextSessionHasComeMeanwhile) {
  BoardSlot slot(0, {});
  for (int i = 0; i < 20; ++i) {
    std::thread owner;
    const auto make_way = [&](wire::ErrorCode, const std::string&) {
      owner = std::thread([&slot] {
        slot.release();
        while (slot.claim(nobody()) != Claim::kGranted) std::this_thread::yield();
      });
    };
    ASSERT_EQ(slot.claim({.end_session = make_way}), Claim::kGranted);
    std::string reason;
    EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kDone);
    owner.join();
    slot.release();
  }
}

TEST(BoardSlot, SessionsAndManagementMeetInAnyOrder) {
  constexpr std::chrono::milliseconds kPause{20};  // so that sessions get their turn
  ServedBoards boards;
  BoardSlot& slot = *boards.slots[0];
  std::atomic<bool> done{false};
  std::thread watcher([&] {
    while (!done) {
      slot.counters();
      slot.info();
      std::this_thread::yield();
    }
  });
  std::thread resetter([&] {
    while (!done) {
      std::string reason;
      EXPECT_EQ(slot.power_reset(reason), BoardSlot::Configured::kDone);
      std::this_thread::sleep_for(kPause);
    }
  });
  std::thread configurer([&] {
    for (int i = 0; !done; ++i) {
      std::string reason;
      slot.configure(i % 2 == 0 ? "asic { processors: 8 }" : "asic { processors: 4 }", reason);
      EXPECT_EQ(reason, "");
      std::this_thread::sleep_for(kPause);
    }
  });
  for (int i = 0; i < 10; ++i) {
    reference::RawClient client = boards.connect();
    client.handshake();  // may be refused, and may be ended at any time
    client.write_register(wire::reg::kStep, wire::kStepOne);
    client.read_register(wire::reg::kId);
  }
  done = true;
  watcher.join();
  resetter.join();
  configurer.join();
  EXPECT_TRUE(serves_afresh(boards));
}

}  // namespace
}  // namespace gicube::emu
