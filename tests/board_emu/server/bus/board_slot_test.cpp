// The slot is where sessions and management meet: no gRPC here, so that ThreadSanitizer sees every access.
#include "server/bus/board_slot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <new>
#include <thread>

#include "served_boards.h"

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
    EXPECT_THAT(answer->text(), testing::HasSubstr("board 0: the system has no memory left for the board"));
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
  EXPECT_THAT(reason, testing::HasSubstr("no memory left"));
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
