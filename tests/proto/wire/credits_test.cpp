// Credits of one direction (reliable_window.h).
#include <rapidcheck/gtest.h>

#include "gicube/wire/reliable_window.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(SendCredits, LimitBothFramesAndBytesInFlight) {
  SendCredits credits({2, 100});
  EXPECT_TRUE(credits.can_send(100));
  EXPECT_FALSE(credits.can_send(101));
  credits.take(60);
  EXPECT_TRUE(credits.can_send(40));
  EXPECT_FALSE(credits.can_send(41));
  credits.take(0);
  EXPECT_FALSE(credits.can_send(0)) << "both slots are taken";
  credits.give_back({1, 60});
  EXPECT_TRUE(credits.can_send(100));
}

TEST(ReceiveCredits, NoticeAPeerThatSendsMoreThanItWasGranted) {
  ReceiveCredits credits({2, 100});
  EXPECT_TRUE(credits.accept(100));
  EXPECT_FALSE(credits.accept(1)) << "no byte is left";
  EXPECT_TRUE(credits.accept(0));
  EXPECT_FALSE(credits.accept(0)) << "no slot is left";
}

TEST(ReceiveCredits, OpenTheWindowWhenCreditIsGivenBackNotWhenItIsConsumed) {
  ReceiveCredits credits({1, 100});
  ASSERT_TRUE(credits.accept(100));
  credits.consume(100);
  EXPECT_FALSE(credits.accept(0));
  const auto returned = credits.give_back();
  EXPECT_EQ(returned.slots, 1u);
  EXPECT_EQ(returned.bytes, 100u);
  EXPECT_TRUE(credits.accept(100));
  EXPECT_EQ(credits.give_back().slots, 0u) << "credit is given back once";
}

TEST(ReceiveCredits, AreDueFromHalfTheWindowOn) {
  ReceiveCredits credits({8, 100});
  ASSERT_TRUE(credits.accept(49));
  credits.consume(49);
  EXPECT_FALSE(credits.due());
  ASSERT_TRUE(credits.accept(1));
  credits.consume(1);
  EXPECT_TRUE(credits.due()) << "half of the bytes";

  ReceiveCredits slots({4, 100});
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(slots.due());
    ASSERT_TRUE(slots.accept(0));
    slots.consume(0);
  }
  EXPECT_TRUE(slots.due()) << "half of the slots";
}

// One direction of a link: what has been sent and not arrived, what has arrived and is not consumed, and credit under
// way back to the sender.
class Direction {
 public:
  Direction(std::uint32_t slots, std::uint64_t bytes) : sender_({slots, bytes}), receiver_({slots, bytes}) {}

  bool send(std::uint64_t payload) {
    if (!sender_.can_send(payload)) return false;
    sender_.take(payload);
    sent_.push_back(payload);
    return true;
  }

  void arrive() {
    if (sent_.empty()) return;
    RC_ASSERT(receiver_.accept(sent_.front()));  // a sender that keeps its credits is never turned away
    arrived_.push_back(sent_.front());
    sent_.pop_front();
  }

  void consume() {
    if (arrived_.empty()) return;
    receiver_.consume(arrived_.front());
    arrived_.pop_front();
  }

  void give_back() { returns_.push_back(receiver_.give_back()); }

  void take_credit() {
    if (returns_.empty()) return;
    sender_.give_back(returns_.front());
    returns_.pop_front();
  }

  // Everything takes its course, and the receiver gives back only what is due.
  void settle() {
    while (!sent_.empty()) arrive();
    while (!arrived_.empty()) consume();
    if (receiver_.due()) give_back();
    while (!returns_.empty()) take_credit();
  }

 private:
  SendCredits sender_;
  ReceiveCredits receiver_;
  std::deque<std::uint64_t> sent_, arrived_;
  std::deque<Credit> returns_;
};

void step(Direction& direction, std::uint64_t largest) {
  switch (*rc::gen::inRange(0, 6)) {
    case 0: direction.arrive(); break;
    case 1: direction.consume(); break;
    case 2: direction.give_back(); break;
    case 3: direction.take_credit(); break;
    default: direction.send(*rc::gen::inRange<std::uint64_t>(0, largest + 1)); break;
  }
}

RC_GTEST_PROP(Credits, NeverOverrunTheReceiverAndNeverGetLost, ()) {
  const auto slots = *rc::gen::inRange<std::uint32_t>(1, 9);
  const auto bytes = *rc::gen::inRange<std::uint64_t>(1, 200);
  Direction direction(slots, bytes);
  for (int steps = *rc::gen::inRange(0, 200); steps > 0; --steps) step(direction, bytes);
  direction.settle();
  direction.give_back();
  direction.take_credit();
  RC_ASSERT(direction.send(bytes));  // the whole window in one frame
}

RC_GTEST_PROP(Credits, NoFrameWaitsForEverWhenAWindowHoldsTwoOfTheLargest, ()) {
  const auto slots = *rc::gen::inRange<std::uint32_t>(1, 9);
  const auto largest = *rc::gen::inRange<std::uint64_t>(1, 100);
  const auto bytes = 2 * largest + *rc::gen::inRange<std::uint64_t>(0, 50);
  Direction direction(slots, bytes);
  for (int steps = *rc::gen::inRange(0, 200); steps > 0; --steps) step(direction, largest);
  direction.settle();
  RC_ASSERT(direction.send(largest));
}

}  // namespace
}  // namespace gicube::wire
