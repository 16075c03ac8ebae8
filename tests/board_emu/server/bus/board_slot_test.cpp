// The slot is where sessions and management meet: no gRPC here, so that ThreadSanitizer sees every access.
#include "server/bus/board_slot.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "served_boards.h"

namespace gicube::emu {
namespace {

Claimant nobody() {
  return {.end_session = [](wire::ErrorCode, const std::string&) {}};
}

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
  EXPECT_TRUE(slot.power_reset());
  EXPECT_FALSE(slot.info().in_use);
  owner.join();
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
      EXPECT_TRUE(slot.power_reset());
      std::this_thread::sleep_for(kPause);
    }
  });
  std::thread configurer([&] {
    for (int i = 0; !done; ++i) {
      std::vector<Diagnostic> found;
      slot.configure(i % 2 == 0 ? "asic { processors: 8 }" : "asic { processors: 4 }", found);
      EXPECT_TRUE(found.empty());
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
