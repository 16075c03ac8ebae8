#include "transport/link.h"

#include <ctime>

#include "fake_board.h"
#include "gicube/error.h"
#include "test.h"

namespace gicube {
namespace {

using reference::bytes_of;
using reference::FakeBoard;
using reference::Frame;
using wire::FrameType;

TEST(Link, ARequestCarriesTypeTimeAndPayloadAndReturnsTheResponse) {
  Frame seen;
  FakeBoard board(in_session([&seen](FakeBoard& self) {
    seen = *self.receive();
    self.respond(seen, 777, bytes_of("four"));
  }));
  Link link(board.take_socket(), kPatient);
  const Response response = link.request(FrameType::kRegisterRead, 123, bytes_of("abcd"));
  EXPECT_EQ(response.time_ps, 777u);
  EXPECT_EQ(response.payload, bytes_of("four"));
  EXPECT_EQ(seen.header.type, FrameType::kRegisterRead);
  EXPECT_EQ(seen.header.flags & wire::kPosted, 0);
  EXPECT_EQ(seen.header.time_ps, 123u);
  EXPECT_EQ(seen.payload, bytes_of("abcd"));
}

TEST(Link, APostedFrameSaysThatNoResponseFollows) {
  std::uint16_t flags = 0;
  {
    FakeBoard board(in_session([&flags](FakeBoard& self) {
      flags = self.receive()->header.flags;
      self.respond(*self.receive(), 0);
    }));
    Link link(board.take_socket(), kPatient);
    link.post(FrameType::kRegisterWrite, 0, bytes_of("12345678"));
    link.request(FrameType::kCounters, 0, {});
  }
  EXPECT_EQ(flags, wire::kPosted);
}

TEST(Link, ResponsesFindTheirRequestsByIdWhateverTheirOrder) {
  FakeBoard board(in_session([](FakeBoard& self) {
    std::vector<Frame> requests;
    for (int i = 0; i < 4; ++i) requests.push_back(*self.receive());
    for (auto request = requests.rbegin(); request != requests.rend(); ++request) {
      self.respond(*request, 0, request->payload);
    }
  }));
  Link link(board.take_socket(), kPatient);
  std::vector<std::thread> callers;
  std::atomic<int> right = 0;
  for (int i = 0; i < 4; ++i) {
    callers.emplace_back([&link, &right, i] {
      const auto payload = bytes_of("caller " + std::to_string(i));
      if (link.request(FrameType::kRegisterRead, 0, payload).payload == payload) ++right;
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(right, 4);
}

TEST(Link, ManyConcurrentCallersGetTheirOwnAnswers) {
  FakeBoard board([](FakeBoard& self) {
    wire::VersionInfo mine;
    mine.window_slots = 3;
    self.shake_hands(mine);
    while (const auto request = self.receive()) {
      self.return_credit(1, request->payload.size());
      if ((request->header.flags & wire::kPosted) == 0) self.respond(*request, 0, request->payload);
    }
  });
  Link link(board.take_socket(), kPatient);
  std::atomic<int> right = 0;
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 4; ++caller) {
    callers.emplace_back([&link, &right, caller] {
      for (int i = 0; i < 100; ++i) {
        const auto payload = bytes_of(std::to_string(caller) + " " + std::to_string(i));
        link.post(FrameType::kMemoryWrite, 0, payload);
        if (link.request(FrameType::kMemoryRead, 0, payload).payload == payload) ++right;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(right, 400);
}

TEST(Link, ErrorRepliesBecomeTypedErrorsInTheBoardsWordsAndTheLinkGoesOn) {
  FakeBoard board(in_session([](FakeBoard& self) {
    self.refuse(*self.receive(), wire::ErrorCode::kBadAddress, "no register at 0xfff");
    self.refuse(*self.receive(), wire::ErrorCode::kBadValue, "step 0");
    self.refuse(*self.receive(), wire::ErrorCode::kInternal, "a fault");
    self.refuse(*self.receive(), wire::ErrorCode::kUnsupported, "no cycles here");
    self.respond(*self.receive(), 0);
  }));
  Link link(board.take_socket(), kPatient);
  const auto request = [&link] { return link.request(FrameType::kRegisterRead, 0, {}); };
  EXPECT_THROWS(Rejected, "no register at 0xfff", request());
  EXPECT_THROW(request(), Rejected);
  EXPECT_THROW(request(), Rejected);
  EXPECT_THROW(request(), Unsupported);
  EXPECT_NO_THROW(request());
}

TEST(Link, AnErrorThatEndsTheSessionLosesTheDevice) {
  FakeBoard board(
      in_session([](FakeBoard& self) { self.refuse(*self.receive(), wire::ErrorCode::kCancelled, "going down"); }));
  Link link(board.take_socket(), kPatient);
  EXPECT_FALSE(link.is_broken());
  EXPECT_THROW(link.request(FrameType::kRegisterRead, 0, {}), DeviceLost);
  EXPECT_TRUE(link.is_broken());
  EXPECT_THROW(link.check(), DeviceLost);
}

TEST(Link, TheBoardsLastWordIsTheReasonOfTheLoss) {
  FakeBoard board(in_session([](FakeBoard& self) {
    Frame goodbye = *self.receive();
    goodbye.header.type = FrameType::kVersion;
    goodbye.header.id = 0;
    self.refuse(goodbye, wire::ErrorCode::kCancelled, "somebody has reset the board");
  }));
  Link link(board.take_socket(), kPatient);
  EXPECT_THROWS(DeviceLost, "somebody has reset the board", link.request(FrameType::kRegisterRead, 0, {}));
  EXPECT_THROW(link.check(), DeviceLost);
}

TEST(Link, EveryWaiterLearnsThatTheBoardVanished) {
  FakeBoard board([](FakeBoard& self) {
    self.shake_hands();
    for (int i = 0; i < 3; ++i) self.receive();
  });
  Link link(board.take_socket(), kPatient);
  std::atomic<int> lost = 0;
  std::vector<std::thread> callers;
  for (int i = 0; i < 3; ++i) {
    callers.emplace_back([&link, &lost] {
      try {
        link.request(FrameType::kCounters, 0, {});
      } catch (const DeviceLost&) {
        ++lost;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(lost, 3);
  EXPECT_THROW(link.post(FrameType::kRegisterWrite, 0, {}), DeviceLost);
  EXPECT_THROW(link.request(FrameType::kCounters, 0, {}), DeviceLost);
  EXPECT_THROW(link.command(0, wire::no_payload()), DeviceLost);
}

TEST(Link, ABoardThatVanishesInTheMiddleOfAResponseIsLost) {
  FakeBoard board([](FakeBoard& self) {
    self.shake_hands();
    const Frame request = *self.receive();
    wire::FrameHeader header;
    header.type = request.header.type;
    header.flags = wire::kResponse;
    header.id = request.header.id;
    header.size = 1000;
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    encode(header, bytes);
    self.send_bytes(bytes);
    self.send_bytes(bytes_of("only this"));
  });
  Link link(board.take_socket(), kPatient);
  EXPECT_THROWS(DeviceLost, "middle of a frame", link.request(FrameType::kCounters, 0, {}));
}

TEST(Link, ABoardThatVanishesWhileTheDriverWritesIsLost) {
  FakeBoard board([](FakeBoard& self) {
    self.shake_hands();
    self.receive();
  });
  Link link(board.take_socket(), kPatient);
  EXPECT_THROW(
      {
        for (int i = 0; i < 1000; ++i) {
          link.post(FrameType::kMemoryWrite, 0, std::vector<std::uint8_t>(1 << 20));
        }
      },
      DeviceLost);
}

TEST(Link, AResponseThatClaimsFourGigabytesEndsTheSessionBeforeMemoryIsTaken) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame request = *self.receive();
    wire::FrameHeader header;
    header.type = request.header.type;
    header.flags = wire::kResponse;
    header.id = request.header.id;
    header.size = 0xFFFF'FFFF;
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    encode(header, bytes);
    self.send_bytes(bytes);
  }));
  Link link(board.take_socket(), kPatient);
  EXPECT_THROWS(DeviceLost, "4294967295", link.request(FrameType::kCounters, 0, {}));
}

TEST(Link, AResponseBeyondTheAgreedLimitIsRefusedWithBothSizes) {
  FakeBoard board([](FakeBoard& self) {
    wire::VersionInfo mine;
    mine.max_payload_bytes = 5000;
    self.shake_hands(mine);
    self.respond(*self.receive(), 0, std::vector<std::uint8_t>(5000));
    self.respond(*self.receive(), 0, std::vector<std::uint8_t>(5001));
    self.drain();
  });
  Link link(board.take_socket(), kPatient);
  EXPECT_EQ(link.request(FrameType::kCounters, 0, {}).payload.size(), 5000u);
  EXPECT_THROWS(DeviceLost, "the board announced 5001 payload bytes, agreed were at most 5000",
                link.request(FrameType::kCounters, 0, {}));
}

TEST(Link, AnAnswerThatIsNotMarkedAsOneIsAFault) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame request = *self.receive();
    wire::FrameHeader header{request.header.type};
    header.id = request.header.id;
    self.send(header);
  }));
  Link link(board.take_socket(), kPatient);
  EXPECT_THROWS(DeviceLost, "not made", link.request(FrameType::kCounters, 0, {}));
}

TEST(Link, EachErrorOfTheBoardHasItsOwnType) {
  using enum wire::ErrorCode;
  const auto text = [](wire::ErrorCode code) {
    try {
      throw_error(code, "words");
    } catch (const BoardBusy& error) {
      return std::string("BoardBusy ") + error.what();
    } catch (const VersionMismatch& error) {
      return std::string("VersionMismatch ") + error.what();
    } catch (const Unsupported& error) {
      return std::string("Unsupported ") + error.what();
    } catch (const MemoryFault& error) {
      return std::string("MemoryFault ") + error.what();
    } catch (const DeviceLost& error) {
      return "DeviceLost " + std::to_string(static_cast<int>(error.cause())) + ' ' + error.what();
    } catch (const Rejected& error) {
      return std::string("Rejected ") + error.what();
    }
  };
  const auto lost = [](Loss cause) { return "DeviceLost " + std::to_string(static_cast<int>(cause)) + ' '; };
  EXPECT_EQ(text(kBusy), "BoardBusy the board is busy: words");
  EXPECT_EQ(text(kVersion), "VersionMismatch the board has another protocol version: words");
  EXPECT_EQ(text(kUnsupported), "Unsupported words");
  EXPECT_EQ(text(kMemory), "MemoryFault words");
  EXPECT_EQ(text(kProtocol), lost(Loss::kEnded) + "the board ended the session: words");
  EXPECT_EQ(text(kTooLarge), lost(Loss::kEnded) + "the board ended the session: words");
  EXPECT_EQ(text(kCancelled), lost(Loss::kEnded) + "the board shuts down: words");
  EXPECT_EQ(text(kCorrupted), lost(Loss::kCorrupted) + "words");
  EXPECT_EQ(text(kTaken), lost(Loss::kTakenOver) + "words");
  EXPECT_EQ(text(kBadValue), "Rejected words");
  EXPECT_TRUE(ends_session(kTaken));
  EXPECT_TRUE(ends_session(kProtocol));
  EXPECT_FALSE(ends_session(kBadValue));
}

TEST(Link, WhatTheBoardDoesNotOweIsAFault) {
  const auto reason_after = [](const FakeBoard::Script& misbehave) {
    FakeBoard board(in_session([&misbehave](FakeBoard& self) { misbehave(self); }));
    Link link(board.take_socket(), kPatient);
    return message_of<std::exception>([&] { link.request(FrameType::kCounters, 0, {}); });
  };
  EXPECT_THAT(reason_after([](FakeBoard& self) {
                self.receive();
                self.complete(99, 0);
              }),
              HasSubstr("unknown command 99"));
  EXPECT_THAT(reason_after([](FakeBoard& self) {
                self.receive();
                self.return_credit(5, 0);
              }),
              HasSubstr("credit that it never took"));
  EXPECT_THAT(reason_after([](FakeBoard& self) {
                Frame request = *self.receive();
                request.header.id += 5;
                self.respond(request, 0);
              }),
              HasSubstr("not made"));
  EXPECT_THAT(reason_after([](FakeBoard& self) {
                Frame request = *self.receive();
                request.header.type = FrameType::kPoll;
                self.respond(request, 0);
              }),
              HasSubstr("not made"));
  EXPECT_THAT(reason_after([](FakeBoard& self) {
                self.receive();
                self.send_bytes(std::vector<std::uint8_t>(wire::kFrameHeaderBytes, 'x'));
              }),
              HasSubstr("not a frame"));
}

TEST(Link, APayloadBeyondTheAgreedLimitIsNeverSent) {
  FakeBoard board([](FakeBoard& self) {
    wire::VersionInfo mine;
    mine.max_payload_bytes = 5000;
    self.shake_hands(mine);
    self.drain();
  });
  Link link(board.take_socket(), kPatient);
  EXPECT_NO_THROW(link.post(FrameType::kMemoryWrite, 0, std::vector<std::uint8_t>(5000)));
  EXPECT_THAT([&] { link.post(FrameType::kMemoryWrite, 0, std::vector<std::uint8_t>(5001)); },
              ThrowsMessage<BadArgument>("payload: expected at most 5000 bytes, got 5001"));
  EXPECT_NO_THROW(link.check());
}

TEST(Link, AnErrorsTextIsCutAtFourThousandBytes) {
  EXPECT_EQ(error_text(std::vector<std::uint8_t>(5000, 'a')), std::string(4000, 'a'));
  EXPECT_EQ(error_text({}), "no reason given");
}

TEST(Link, TakesNoProcessorTimeWhileItWaits) {
  FakeBoard board(in_session([](FakeBoard& self) {
    const Frame request = *self.receive();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    self.respond(request, 0);
  }));
  Link link(board.take_socket(), kPatient);
  const std::clock_t before = std::clock();  // of all threads
  link.request(FrameType::kCounters, 0, {});
  EXPECT_LT(std::clock() - before, CLOCKS_PER_SEC / 10);
}

}  // namespace
}  // namespace gicube
