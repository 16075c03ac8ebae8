// Credits of both directions as the wire sees them.
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

wire::VersionInfo window(std::uint32_t slots, std::uint64_t bytes) {
  wire::VersionInfo info;
  info.max_payload_bytes = 4096;
  info.window_slots = slots;
  info.window_bytes = bytes;
  return info;
}

TEST(Credit, TheDriverNeverHasMoreFramesInFlightThanTheBoardGranted) {
  std::vector<std::size_t> bursts;
  {
    FakeBoard board(in_session(
        [&bursts](FakeBoard& self) {
          for (int burst = 0; burst < 3; ++burst) {
            std::size_t frames = 0;
            while (self.readable_within(100)) {
              self.receive();
              ++frames;
            }
            bursts.push_back(frames);
            self.return_credit(static_cast<std::uint32_t>(frames), 8 * frames);
          }
          self.respond(*self.receive_until(FrameType::kCounters), 0);
        },
        window(4, 1 << 20)));
    Link link(board.take_socket(), kPatient);
    for (int i = 0; i < 12; ++i) link.post(FrameType::kRegisterWrite, 0, bytes_of("12345678"));
    link.request(FrameType::kCounters, 0, {});
  }
  EXPECT_THAT(bursts, ElementsAre(4, 4, 4));
}

TEST(Credit, TheDriverNeverHasMoreBytesInFlightThanTheBoardGranted) {
  std::vector<std::size_t> bursts;
  {
    FakeBoard board(in_session(
        [&bursts](FakeBoard& self) {
          for (int burst = 0; burst < 2; ++burst) {
            std::size_t bytes = 0, frames = 0;
            while (self.readable_within(100)) {
              bytes += self.receive()->payload.size();
              ++frames;
            }
            bursts.push_back(bytes);
            self.return_credit(static_cast<std::uint32_t>(frames), bytes);
          }
          self.respond(*self.receive_until(FrameType::kCounters), 0);
        },
        window(100, 10'000)));
    Link link(board.take_socket(), kPatient);
    for (int i = 0; i < 6; ++i) link.post(FrameType::kMemoryWrite, 0, std::vector<std::uint8_t>(3000));
    link.request(FrameType::kCounters, 0, std::vector<std::uint8_t>(3000));
  }
  EXPECT_THAT(bursts, ElementsAre(9000, 9000));
}

TEST(Credit, AWriterThatWaitsForCreditLearnsThatTheBoardVanished) {
  FakeBoard board([](FakeBoard& self) {
    self.shake_hands(window(2, 1 << 20));
    self.receive();
    self.receive();
  });
  Link link(board.take_socket(), kPatient);
  EXPECT_THROW(
      {
        for (int i = 0; i < 3; ++i) link.post(FrameType::kRegisterWrite, 0, {});
      },
      DeviceLost);
}

TEST(Credit, AWriterThatWaitsForCreditRunsIntoTheWatchdog) {
  FakeBoard board(in_session([](FakeBoard&) {}, window(2, 1 << 20)));
  Link link(board.take_socket(), {.watchdog = std::chrono::milliseconds(50)});
  link.post(FrameType::kRegisterWrite, 0, {});
  link.post(FrameType::kRegisterWrite, 0, {});
  EXPECT_THROW(link.post(FrameType::kRegisterWrite, 0, {}), TimedOut);
}

// A question is a credit frame that is not posted. The board's end leaves questions out, and nothing else.
TEST(Credit, ACallThatWaitsLongAsksWhatTheBoardHasSent) {
  bool asked = false;
  FrameType type{};
  {
    FakeBoard board(in_session([&](FakeBoard& self) {
      const Frame first = *self.receive();
      asked = self.readable_within(60'000);
      self.respond(first, 0);
      if (const auto second = self.receive()) {
        type = second->header.type;
        self.respond(*second, 0);
      }
    }));
    Link link(board.take_socket(), {.watchdog = std::chrono::seconds(60), .probe = std::chrono::milliseconds(1)});
    link.request(FrameType::kPoll, 0, {});
    link.request(FrameType::kCounters, 0, {});
  }
  EXPECT_TRUE(asked);
  EXPECT_EQ(type, FrameType::kCounters);
}

TEST(Credit, CreditMayComeOnAnyFrameOfTheBoard) {
  FakeBoard board([](FakeBoard& self) {
    self.shake_hands(window(1, 1 << 20));
    while (const auto request = self.receive()) {
      wire::FrameHeader header;
      header.type = request->header.type;
      header.flags = wire::kResponse;
      header.id = request->header.id;
      header.credit_slots = 1;
      header.credit_bytes = request->payload.size();
      self.send(header);
    }
  });
  Link link(board.take_socket(), kPatient);
  for (int i = 0; i < 20; ++i) EXPECT_NO_THROW(link.request(FrameType::kRegisterRead, 0, bytes_of("1234")));
}

TEST(Credit, TheDriverHandsBackAllThatItHasConsumed) {
  constexpr int kRequests = 100;
  std::uint64_t slots = 0, bytes = 0;
  {
    FakeBoard board([&](FakeBoard& self) {
      self.shake_hands();
      const std::vector<std::uint8_t> answer(1000);
      while (const auto frame = self.receive()) {
        slots += frame->header.credit_slots;
        bytes += frame->header.credit_bytes;
        if (frame->header.type == FrameType::kCredit) continue;
        self.return_credit(1, frame->payload.size());
        self.respond(*frame, 0, answer);
      }
    });
    Link link(board.take_socket(), kPatient);
    for (int i = 0; i < kRequests; ++i) link.request(FrameType::kMemoryRead, 0, {});
  }
  // The last response's credit has no frame left to travel on.
  EXPECT_EQ(slots, std::uint64_t{kRequests - 1});
  EXPECT_EQ(bytes, std::uint64_t{1000} * (kRequests - 1));
}

TEST(Credit, ABoardThatOnlySendsGetsCreditFramesAtHalfTheWindow) {
  std::uint64_t returned = 0;
  FakeBoard board([&returned](FakeBoard& self) {
    self.shake_hands();
    std::vector<Frame> commands;
    while (commands.size() < 8) commands.push_back(*self.receive());
    for (const Frame& command : commands) self.complete(command.header.id, 0, std::vector<std::uint8_t>(4000));
    returned = self.receive_until(FrameType::kCredit)->header.credit_slots;
    self.drain();
  });
  {
    LinkOptions options = kPatient;
    options.mine.window_slots = 16;
    Link link(board.take_socket(), options);
    std::vector<std::uint32_t> tickets;
    for (int i = 0; i < 8; ++i) tickets.push_back(link.command(0, wire::no_payload()));
    while (!link.take(tickets.back())) std::this_thread::yield();
  }
}

TEST(Credit, ALargeWriteAndALargeAnswerDoNotWaitForEachOther) {
  // The board answers each write with more than a socket buffer holds and reads nothing meanwhile.
  constexpr int kCommands = 16;
  constexpr std::size_t kBytes = 1 << 20;
  FakeBoard board(in_session([](FakeBoard& self) {
    const std::vector<std::uint8_t> answer(kBytes);
    for (int i = 0; i < kCommands; ++i) {
      const Frame command = *self.receive_until(FrameType::kCommand);
      self.return_credit(1, command.payload.size());
      self.complete(command.header.id, 0, answer);
    }
    self.respond(*self.receive_until(FrameType::kWait), 0);
  }));
  Link link(board.take_socket(), kPatient);
  std::uint32_t last = 0;
  for (int i = 0; i < kCommands; ++i) last = link.command(0, wire::share(std::vector<std::uint8_t>(kBytes)));
  EXPECT_NO_THROW(link.wait(last, 0, kNoDeadline, {}));
  EXPECT_EQ(link.take(last)->payload.size(), kBytes);
}

}  // namespace
}  // namespace gicube
