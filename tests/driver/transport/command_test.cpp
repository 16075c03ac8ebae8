// Commands, their completions and their progress.
#include <future>

#include "fake_board.h"
#include "gicube/error.h"
#include "test.h"
#include "transport/link.h"

namespace gicube {
namespace {

using reference::bytes_of;
using reference::FakeBoard;
using reference::Frame;
using wire::FrameType;

TEST(Command, TheTicketIsTheFramesId) {
  std::uint32_t seen = 0;
  std::uint32_t ticket = 0;
  {
    FakeBoard board(in_session([&seen](FakeBoard& self) {
      seen = self.receive()->header.id;
      self.respond(*self.receive(), 0);
    }));
    Link link(board.take_socket(), kPatient);
    ticket = link.command(0, wire::share(bytes_of("draw")));
    link.request(FrameType::kPoll, 0, {});
  }
  EXPECT_NE(ticket, 0u);
  EXPECT_EQ(seen, ticket);
}

TEST(Command, AWaitHasItsTicketAndADeadlineOnlyIfThereIsOne) {
  std::vector<Frame> waits;
  {
    FakeBoard board(in_session([&waits](FakeBoard& self) {
      for (int i = 0; i < 2; ++i) {
        waits.push_back(*self.receive());
        self.respond(waits.back(), 0);
      }
    }));
    Link link(board.take_socket(), kPatient);
    link.wait(0x01020304, 0, kNoDeadline, {});
    link.wait(5, 0, 0x1122334455667788, {});
  }
  EXPECT_EQ(waits[0].payload, (std::vector<std::uint8_t>{4, 3, 2, 1}));
  EXPECT_EQ(waits[1].payload, (std::vector<std::uint8_t>{5, 0, 0, 0, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11}));
}

TEST(Command, AResultIsKeptUntilItIsTakenOnce) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame first = *self.receive();
    const Frame second = *self.receive();
    const Frame poll = *self.receive();
    self.complete(second.header.id, 20, bytes_of("two"));
    self.complete(first.header.id, 30, bytes_of("one"));
    self.respond(poll, 40);
  }));
  Link link(board.take_socket(), kPatient);
  const auto first = link.command(0, wire::no_payload());
  const auto second = link.command(0, wire::no_payload());
  EXPECT_FALSE(link.take(first));
  link.request(FrameType::kPoll, 40, {});
  EXPECT_EQ(link.take(first)->payload, bytes_of("one"));
  const auto result = link.take(second);
  EXPECT_EQ(result->payload, bytes_of("two"));
  EXPECT_EQ(result->time_ps, 20u);
  EXPECT_FALSE(link.take(second));
}

TEST(Command, ACompletionTwiceIsAFault) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame command = *self.receive();
    self.complete(command.header.id, 20);
    self.complete(command.header.id, 20);
  }));
  Link link(board.take_socket(), kPatient);
  const auto ticket = link.command(0, wire::no_payload());
  EXPECT_THROW(link.wait(ticket, 0, kNoDeadline, {}), DeviceLost);
}

TEST(Command, AForgottenResultIsDroppedWhenItComes) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame command = *self.receive();
    const Frame poll = *self.receive();
    self.complete(command.header.id, 20, bytes_of("late"));
    self.respond(poll, 40);
  }));
  Link link(board.take_socket(), kPatient);
  const auto ticket = link.command(0, wire::no_payload());
  link.forget(ticket);
  EXPECT_NO_THROW(link.request(FrameType::kPoll, 40, {}));
  EXPECT_FALSE(link.take(ticket));
}

TEST(Command, ProgressReachesTheWaitingCallerOnItsOwnThread) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame command = *self.receive();
    const Frame wait = *self.receive();
    self.progress(command.header.id + 7, 99, 99);  // of a command that nobody waits for
    self.progress(command.header.id, 3, 8);
    self.complete(command.header.id, 20);
    self.respond(wait, 20);
  }));
  Link link(board.take_socket(), kPatient);
  const auto ticket = link.command(0, wire::no_payload());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> heard;
  const auto caller = std::this_thread::get_id();
  link.wait(ticket, 0, kNoDeadline, [&](std::uint32_t done, std::uint32_t all) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    heard.emplace_back(done, all);
  });
  EXPECT_THAT(heard, ElementsAre(std::pair(3u, 8u)));
}

TEST(Command, ProgressThatComesAfterACallbackHasReturnedIsHeardToo) {
  std::promise<void> returned;
  FakeBoard board(in_session([&returned](FakeBoard& self) {
    const Frame command = *self.receive();
    const Frame wait = *self.receive();
    self.progress(command.header.id, 1, 2);
    returned.get_future().wait();
    self.progress(command.header.id, 2, 2);
    self.complete(command.header.id, 20);
    self.respond(wait, 20);
  }));
  Link link(board.take_socket(), kPatient);
  const auto ticket = link.command(0, wire::no_payload());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> heard;
  link.wait(ticket, 0, kNoDeadline, [&](std::uint32_t done, std::uint32_t all) {
    heard.emplace_back(done, all);
    if (heard.size() == 1) returned.set_value();
  });
  EXPECT_THAT(heard, ElementsAre(std::pair(1u, 2u), std::pair(2u, 2u)));
}

TEST(Command, WhatIsThrownWhileItIsWaitedForLeavesTheWaitAndTheLinkGoesOn) {
  FakeBoard board([](FakeBoard& self) {
    self.shake_hands();
    const Frame command = *self.receive();
    const Frame wait = *self.receive();
    const Frame next = *self.receive();
    self.complete(command.header.id, 20);
    self.respond(wait, 20);
    self.respond(next, 30);
    self.drain();
  });
  struct Stop {};
  int asked = 0;
  LinkOptions options = kPatient;
  options.probe = std::chrono::milliseconds(5);  // how often it is asked, too
  options.while_waiting = [&asked] {
    if (++asked == 3) throw Stop();
  };
  Link link(board.take_socket(), options);
  const auto ticket = link.command(0, wire::no_payload());
  EXPECT_THROW(link.wait(ticket, 0, kNoDeadline, {}), Stop);
  EXPECT_EQ(asked, 3);
  EXPECT_EQ(link.request(wire::FrameType::kRegisterRead, 0, {}).time_ps, 30u);
  EXPECT_EQ(link.take(ticket)->time_ps, 20u);
}

TEST(Command, WhatIsThrownDuringTheHandshakeLeavesTheConstructor) {
  FakeBoard board([](FakeBoard& self) { self.drain(); });
  struct Stop {};
  LinkOptions options = kPatient;
  options.probe = std::chrono::milliseconds(5);
  options.while_waiting = [] { throw Stop(); };
  EXPECT_THROW(Link(board.take_socket(), options), Stop);
}

TEST(Command, WhatAProgressCallbackThrowsLeavesTheWaitAndTheLinkGoesOn) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame command = *self.receive();
    const Frame wait = *self.receive();
    self.progress(command.header.id, 1, 2);
    const Frame next = *self.receive();
    self.complete(command.header.id, 20);
    self.respond(wait, 20);
    self.respond(next, 30, bytes_of("fine"));
  }));
  Link link(board.take_socket(), kPatient);
  const auto ticket = link.command(0, wire::no_payload());
  EXPECT_THROW(
      link.wait(ticket, 0, kNoDeadline, [](std::uint32_t, std::uint32_t) { throw std::runtime_error("enough"); }),
      std::runtime_error);
  EXPECT_EQ(link.request(FrameType::kCounters, 0, {}).payload, bytes_of("fine"));
  EXPECT_TRUE(link.take(ticket));
}

}  // namespace
}  // namespace gicube
