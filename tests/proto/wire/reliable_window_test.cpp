#include "gicube/wire/reliable_window.h"

#include <rapidcheck/gtest.h>

#include "test.h"

namespace gicube::wire {
namespace {

using Arrival = ReliableWindow::Arrival;

VersionInfo small_window() {
  VersionInfo info;
  info.window_slots = 4;
  info.window_bytes = 100;
  return info;
}

FrameHeader posted() { return FrameHeader{FrameType::kCommand, kPosted}; }

// Two ends and what is under way between them. A broken connection loses all of that.
struct Ends {
  ReliableWindow sender{small_window()}, receiver{small_window()};
  std::deque<ReliableWindow::Sent> down;
  std::deque<FrameHeader> up;
  std::uint32_t made = 0;
  std::vector<std::uint32_t> taken;
  std::deque<std::size_t> unconsumed;

  Ends() {
    sender.open(small_window());
    receiver.open(small_window());
  }

  void send(std::size_t bytes) {
    if (!sender.can_send(bytes)) return;
    FrameHeader header = posted();
    header.id = ++made;
    down.push_back(sender.keep(header, share(std::vector<std::uint8_t>(bytes))));
  }
  void arrive() {
    if (down.empty()) return;
    const auto frame = down.front();
    down.pop_front();
    if (receiver.arrival(frame.header) == Arrival::kAgain) return;
    RC_ASSERT(receiver.arrival(frame.header) == Arrival::kNext);
    receiver.take();
    RC_ASSERT(receiver.accept(frame.payload->size()));
    taken.push_back(frame.header.id);
    unconsumed.push_back(frame.payload->size());
  }
  void consume() {
    if (unconsumed.empty()) return;
    receiver.consume(unconsumed.front());
    unconsumed.pop_front();
  }
  void give_back() { up.push_back(receiver.credit_frame(kPosted)); }
  void take_credit() {
    if (up.empty()) return;
    RC_ASSERT(sender.take_credit(up.front()));
    up.pop_front();
  }
  void reconnect() {
    down.clear();
    up.clear();
    VersionInfo theirs;
    receiver.announce(theirs);
    RC_ASSERT(sender.fits(theirs));
    sender.resume(theirs, [this](const FrameHeader& header, const Payload& payload) {
      down.push_back({header, payload});
    });
  }
};

RC_GTEST_PROP(ReliableWindow, EachFrameComesOnceAndInOrderOverBrokenConnections, ()) {
  Ends ends;
  for (int steps = *rc::gen::inRange(0, 300); steps > 0; --steps) {
    switch (*rc::gen::inRange(0, 8)) {
      case 0:
      case 1: ends.send(*rc::gen::inRange<std::size_t>(0, 60)); break;
      case 2:
      case 3: ends.arrive(); break;
      case 4: ends.consume(); break;
      case 5: ends.give_back(); break;
      case 6: ends.take_credit(); break;
      default: ends.reconnect(); break;
    }
  }
  ends.reconnect();
  while (!ends.down.empty()) ends.arrive();
  while (!ends.unconsumed.empty()) ends.consume();
  ends.give_back();
  ends.take_credit();
  std::vector<std::uint32_t> all(ends.made);
  for (std::uint32_t i = 0; i < ends.made; ++i) all[i] = i + 1;
  RC_ASSERT(ends.taken == all);
  RC_ASSERT(ends.sender.can_send(100));  // all credit has come back
  RC_ASSERT(ends.sender.kept_frames() == 0u);
}

TEST(ReliableWindow, RefusesCreditForFramesThatWereNotSent) {
  Ends ends;
  ends.send(10);
  FrameHeader credit{FrameType::kCredit, kPosted};
  credit.credit_slots = 2;
  credit.credit_bytes = 10;
  EXPECT_FALSE(ends.sender.take_credit(credit));
  credit.credit_slots = 1;
  credit.credit_bytes = 11;
  EXPECT_FALSE(ends.sender.take_credit(credit));
  credit.credit_bytes = 10;
  EXPECT_TRUE(ends.sender.take_credit(credit));
}

TEST(ReliableWindow, NoticesMissingFramesByTheNextNumberAndByACreditFrame) {
  Ends ends;
  ends.send(1);
  ends.send(1);
  EXPECT_EQ(ends.receiver.arrival(ends.down.back().header), Arrival::kGap);
  EXPECT_EQ(ends.receiver.arrival(ends.sender.credit_frame(0)), Arrival::kGap);
  EXPECT_EQ(ends.receiver.arrival(FrameHeader{FrameType::kProgress, kPosted}), Arrival::kNext);
}

TEST(ReliableWindow, RefusesToResumeWhereFramesAreGone) {
  Ends ends;
  ends.send(1);
  VersionInfo theirs;
  theirs.taken = 2;
  EXPECT_FALSE(ends.sender.fits(theirs)) << "more than was sent";
  theirs.taken = 0;
  theirs.consumed = 1;
  EXPECT_FALSE(ends.sender.fits(theirs)) << "consumed, but not taken";
  theirs.taken = 1;
  EXPECT_TRUE(ends.sender.fits(theirs));
}

}  // namespace
}  // namespace gicube::wire
