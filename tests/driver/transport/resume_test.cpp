// Links whose connection breaks, against scripted boards: one for each connection.
#include <future>

#include "gicube/wire/checksum.h"
#include "resuming_boards.h"
#include "test.h"

namespace gicube {
namespace {

using reference::bytes_of;
using reference::Frame;

TEST(Resume, SendsAgainWhatTheBoardHasNotTakenAndNothingElse) {
  std::vector<Frame> again;
  wire::VersionInfo said;
  Boards boards({hang_up_after(3), [&](FakeBoard& self) {
                   said = self.shake_hands(board_with_session(1, 1));
                   for (int i = 0; i < 3; ++i) again.push_back(*self.receive());
                   self.respond(again.back(), 5);
                   self.drain();
                 }});
  Link link(boards.connect(), boards.options());
  link.post(FrameType::kRegisterWrite, 1, bytes_of("aaaaaaaa"));
  link.post(FrameType::kRegisterWrite, 2, bytes_of("bbbbbbbb"));
  EXPECT_EQ(cause_of_loss(link), Loss::kClosed);
  EXPECT_TRUE(link.resume());
  EXPECT_EQ(link.request(FrameType::kPoll, 3, {}).time_ps, 5u);
  EXPECT_EQ(said.session, kToken);
  ASSERT_EQ(again.size(), 3u);
  EXPECT_EQ(again[0].payload, bytes_of("bbbbbbbb"));
  EXPECT_EQ(again[0].header.sequence, 2u);
  EXPECT_EQ(again[0].header.time_ps, 2u);
  EXPECT_EQ(again[1].header.type, FrameType::kCounters) << "the request whose call failed";
  EXPECT_EQ(again[1].header.sequence, 3u);
  EXPECT_EQ(again[2].header.sequence, 4u);
}

TEST(Resume, ByItselfLetsTheCallGoOn) {
  Boards boards({hang_up_after(1), [](FakeBoard& self) {
                   self.shake_hands(board_with_session());
                   self.respond(*self.receive(), 9, bytes_of("four"));
                   self.drain();
                 }});
  std::vector<std::string> told;
  LinkOptions options = boards.options(1);
  options.log = [&told](const std::string& text) { told.push_back(text); };
  Link link(boards.connect(), options);
  EXPECT_THAT(told, IsEmpty());
  const Response response = link.request(FrameType::kRegisterRead, 0, bytes_of("abcd"));
  EXPECT_EQ(response.time_ps, 9u);
  EXPECT_EQ(response.payload, bytes_of("four"));
  EXPECT_THAT(
      told, ElementsAre(testing::MatchesRegex("the connection to the board was lost \\(.+\\); the session continues")));
}

TEST(Resume, IsOverOnceTheDriverHasGivenUp) {
  Boards boards({[](FakeBoard& self) {
                   self.shake_hands(board_with_session());
                   self.drain();
                 },
                 [](FakeBoard&) {}});
  Link link(boards.connect(), boards.options(1));
  EXPECT_THROW(link.give_up("it can't have meant that"), DeviceLost);
  EXPECT_EQ(text_of_loss(link), "the board is lost: it can't have meant that");
  EXPECT_FALSE(link.resume());
  EXPECT_NO_THROW(boards.connect()) << "the second was not asked for";
}

// Without a session there is nothing to resume, however many attempts there may be.
TEST(Resume, ByItselfNeedsASession) {
  Boards boards({[](FakeBoard& self) {
                   self.shake_hands();
                   self.receive();
                 },
                 [](FakeBoard&) {}});
  Link link(boards.connect(), boards.options(3));
  EXPECT_EQ(cause_of_loss(link), Loss::kClosed);
  EXPECT_NO_THROW(boards.connect()) << "the second was not asked for";
}

TEST(Resume, ByItselfEndsAfterSoManyAttemptsWithoutProgress) {
  Boards boards(std::deque(4, hang_up_after(1)));
  Link link(boards.connect(), boards.options(2));
  EXPECT_EQ(cause_of_loss(link), Loss::kClosed);
  EXPECT_NO_THROW(boards.connect()) << "the fourth was not asked for";
}

// What a board answers to a question is no progress.
TEST(Resume, ByItselfEndsThoughTheBoardAnswersQuestions) {
  const FakeBoard::Script hangs_up = [](FakeBoard& self) {
    self.shake_hands(board_with_session());
    self.receive();
    self.return_credit(0, 0);
  };
  Boards boards({hangs_up, hangs_up, hangs_up, hangs_up});
  Link link(boards.connect(), boards.options(2));
  EXPECT_EQ(cause_of_loss(link), Loss::kClosed);
  EXPECT_NO_THROW(boards.connect()) << "the fourth was not asked for";
}

// What it has taken once is progress once.
TEST(Resume, ByItselfEndsThoughTheBoardSaysEachTimeWhatItTook) {
  const FakeBoard::Script hangs_up = [](FakeBoard& self) { self.shake_hands(board_with_session(1, 0)); };
  Boards boards({hang_up_after(1), hangs_up, hangs_up, hangs_up, hangs_up});
  Link link(boards.connect(), boards.options(2));
  EXPECT_EQ(cause_of_loss(link), Loss::kClosed);
  EXPECT_NO_THROW(boards.connect()) << "the fifth was not asked for";
}

TEST(Resume, ByItselfTriesAfterLongerAndLongerPausesAndTellsEveryCallerWhyInTheEnd) {
  using Clock = std::chrono::steady_clock;
  Boards boards({hang_up_after(2)});
  std::vector<Clock::time_point> attempts;
  LinkOptions options = boards.options(5);
  options.reconnect = [&] {
    attempts.push_back(Clock::now());
    return boards.connect();
  };
  Link link(boards.connect(), options);
  std::string other_text;
  std::thread other([&] { other_text = text_of_loss(link); });
  EXPECT_EQ(text_of_loss(link), "the board is lost: no board is left");
  other.join();
  EXPECT_EQ(other_text, "the board is lost: no board is left");
  ASSERT_EQ(attempts.size(), 5u);
  // At least: who sleeps may wake up late.
  EXPECT_GE(attempts[4] - attempts[0], std::chrono::milliseconds(10 + 20 + 40 + 80));
}

// Without an answer or a question that would wake it.
TEST(Resume, ByItselfLetsACallSendAtOnce) {
  std::promise<void> opened;
  Boards boards({[&opened](FakeBoard& self) {
                   self.shake_hands(board_with_session());
                   opened.get_future().wait();
                 },
                 [](FakeBoard& self) {
                   self.shake_hands(board_with_session());
                   self.respond(*self.receive(), 9);
                   self.drain();
                 }});
  LinkOptions options = boards.options(1);
  options.watchdog = std::chrono::seconds(10);
  options.probe = std::chrono::hours(1);
  Link link(boards.connect(), options);
  opened.set_value();
  while (!link.is_broken()) std::this_thread::yield();
  EXPECT_EQ(link.request(FrameType::kPoll, 0, {}).time_ps, 9u);
}

TEST(Resume, IsOverWhenTheApplicationClosesWhileTheDriverConnects) {
  bool asked = true;
  {
    std::promise<void> connecting, closed;
    Boards boards({hang_up_after(1), [&asked](FakeBoard& self) { asked = self.receive().has_value(); }});
    LinkOptions options = boards.options(1);
    options.reconnect = [&] {
      connecting.set_value();
      closed.get_future().wait();
      return boards.connect();
    };
    Link link(boards.connect(), options);
    std::string text;
    std::thread caller([&] { text = text_of_loss(link); });
    connecting.get_future().wait();
    link.close();
    closed.set_value();
    caller.join();
    EXPECT_EQ(text, "the board is lost: the application has closed it");
  }
  EXPECT_FALSE(asked) << "the second board has no session";
}

// Its thread hangs in the tap while the link goes on.
TEST(Resume, WhatTheBrokenConnectionStillBringsNeitherDisturbsNorBlocksTheNextOne) {
  for (const bool ends_before : {true, false}) {
    std::promise<void> third, go_on;
    Boards boards({[](FakeBoard& self) {
                     self.shake_hands(board_with_session());
                     self.refuse(*self.receive(), wire::ErrorCode::kTooLarge, "a damaged size");
                     self.return_credit(0, 0);
                     self.drain();
                   },
                   [](FakeBoard& self) {
                     self.shake_hands(board_with_session(1, 0));
                     self.continue_from(1);
                     self.respond(*self.receive(), 9);
                     self.drain();
                   }});
    Link* used = nullptr;
    bool disturbed = false;
    int received = 0;
    LinkOptions options = boards.options(1);
    options.probe = std::chrono::hours(1);
    options.tap = [&](bool sent, auto, auto) {
      if (sent || ++received != 3) return;
      third.set_value();
      go_on.get_future().wait();
      if (!ends_before) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    };
    options.reconnect = [&] {
      go_on.set_value();
      for (int i = 0; ends_before && i < 50 && !disturbed; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        disturbed = used->is_broken();
      }
      return boards.connect();
    };
    Link link(boards.connect(), options);
    used = &link;
    const std::uint32_t request = link.begin(FrameType::kCounters, 0, {});
    third.get_future().wait();
    EXPECT_THROW(link.finish(request), DeviceLost);
    EXPECT_EQ(link.request(FrameType::kPoll, 0, {}).time_ps, 9u);
    EXPECT_FALSE(disturbed) << "another caller would resume it, too";
  }
}

TEST(Resume, IsTheAffairOfOneOfSeveralCallers) {
  std::atomic<int> connections{0};
  Boards boards({hang_up_after(2), [](FakeBoard& self) {
                   self.shake_hands(board_with_session());
                   while (const auto request = self.receive()) self.respond(*request, 7);
                 }});
  LinkOptions options = boards.options(3);
  options.reconnect = [&] {
    ++connections;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the other caller has time to try it too
    return boards.connect();
  };
  Link link(boards.connect(), options);
  const auto call = [&link] { EXPECT_EQ(link.request(FrameType::kPoll, 0, {}).time_ps, 7u); };
  std::thread other(call);
  call();
  other.join();
  EXPECT_EQ(connections, 1);
}

TEST(Resume, FramesThatComeAgainAreTakenOnce) {
  Boards boards({[](FakeBoard& self) {
    self.shake_hands(board_with_session());
    const Frame request = *self.receive();
    self.respond(request, 4);
    self.continue_from(0);
    self.respond(request, 4);  // number 1 again: not an answer to nothing
    self.respond(*self.receive(), 6);
    self.drain();
  }});
  Link link(boards.connect(), boards.options());
  EXPECT_EQ(link.request(FrameType::kPoll, 0, {}).time_ps, 4u);
  EXPECT_EQ(link.request(FrameType::kPoll, 0, {}).time_ps, 6u);
}

TEST(Resume, AMissingFrameAndADamagedOneAreCorruption) {
  Boards gap({[](FakeBoard& self) {
    self.shake_hands(board_with_session());
    const Frame request = *self.receive();
    self.continue_from(1);
    self.respond(request, 4);
    self.drain();
  }});
  Link first(gap.connect(), gap.options());
  EXPECT_EQ(cause_of_loss(first), Loss::kCorrupted);

  Boards damage({[](FakeBoard& self) {
    self.shake_hands(board_with_session());
    wire::FrameHeader header;
    header.type = FrameType::kCounters;
    header.flags = wire::kResponse;
    header.id = self.receive()->header.id;
    header.sequence = 1;
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    wire::encode_sealed(header, {}, bytes);
    bytes[30] ^= 4;  // of the time
    self.send_bytes(bytes);
    self.drain();
  }});
  Link second(damage.connect(), damage.options());
  EXPECT_EQ(cause_of_loss(second), Loss::kCorrupted);
}

TEST(Resume, ABoardThatSaysThatItSentMoreHasLostAFrame) {
  Boards boards({[](FakeBoard& self) {
    self.shake_hands(board_with_session());
    self.receive();
    wire::FrameHeader credit;
    credit.type = FrameType::kCredit;
    credit.flags = wire::kResponse;
    credit.id = 1;
    self.send(credit);
    self.drain();
  }});
  Link link(boards.connect(), boards.options());
  EXPECT_EQ(cause_of_loss(link), Loss::kCorrupted);
  EXPECT_THAT(text_of_loss(link), HasSubstr("expected number 1, the board says that it has sent up to number 1"));
}

TEST(Resume, NeedsASessionThatTheBoardKnows) {
  const FakeBoard::Script nameless = [](FakeBoard& self) {
    self.shake_hands();
    self.receive();
  };
  Boards without({nameless, nameless});
  Link first(without.connect(), without.options(3));
  EXPECT_EQ(cause_of_loss(first), Loss::kClosed);
  EXPECT_FALSE(first.resume());

  Boards forgotten({hang_up_after(1), [](FakeBoard& self) {
                      self.refuse(*self.receive(), wire::ErrorCode::kNoSession, "never heard of it");
                      self.drain();
                    }});
  Link second(forgotten.connect(), forgotten.options());
  EXPECT_EQ(cause_of_loss(second), Loss::kClosed);
  EXPECT_FALSE(second.resume());
}

TEST(Resume, ACompletionThatCameBeforeTheBoardKnewOfTheSecondWaitCounts) {
  Boards boards({hang_up_after(2), [](FakeBoard& self) {
                   self.shake_hands(board_with_session(2, 0));
                   self.complete(1, 50, bytes_of("rays"));
                   wire::FrameHeader answer;
                   answer.type = FrameType::kWait;
                   answer.flags = wire::kResponse;
                   answer.id = 2;
                   answer.time_ps = 50;
                   self.send(answer);
                   self.refuse(*self.receive(), wire::ErrorCode::kBadValue, "it has completed already");
                   self.drain();
                 }});
  Link link(boards.connect(), boards.options());
  const std::uint32_t ticket = link.command(0, wire::share(bytes_of("render")));
  EXPECT_THROW(link.wait(ticket, 0, kNoDeadline, {}), DeviceLost);
  EXPECT_TRUE(link.resume());
  EXPECT_EQ(link.wait(ticket, 0, kNoDeadline, {}).time_ps, 50u);
  EXPECT_EQ(link.take(ticket)->payload, bytes_of("rays"));
}

}  // namespace
}  // namespace gicube
