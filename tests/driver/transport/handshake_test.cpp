#include "fake_board.h"
#include "gicube/error.h"
#include "test.h"
#include "transport/link.h"

namespace gicube {
namespace {

using reference::bytes_of;
using reference::FakeBoard;

std::string open_error(FakeBoard::Script script, std::chrono::milliseconds watchdog = std::chrono::seconds(30)) {
  FakeBoard board(std::move(script));
  try {
    const Link link(board.take_socket(), {.watchdog = watchdog});
  } catch (const OpenFailed& error) {
    return std::string("OpenFailed: ") + error.what();
  } catch (const BoardBusy& error) {
    return std::string("BoardBusy: ") + error.what();
  } catch (const VersionMismatch& error) {
    return std::string("VersionMismatch: ") + error.what();
  } catch (const TimedOut& error) {
    return std::string("TimedOut: ") + error.what();
  }
  return "opened";
}

TEST(Handshake, StoresTheSmallerMinorVersionAndLimitsAndTheCommonCapabilities) {
  wire::VersionInfo theirs;
  theirs.minor = 3;
  theirs.max_payload_bytes = 10'000;
  theirs.capabilities = wire::kFunctionalLevel | std::uint64_t{1} << 40;
  FakeBoard board([&theirs](FakeBoard& self) {
    self.shake_hands(theirs);
    self.drain();
  });
  LinkOptions options;
  options.mine.minor = 7;
  const Link link(board.take_socket(), options);
  EXPECT_EQ(link.agreed().minor, 3);
  EXPECT_EQ(link.agreed().max_payload_bytes, 10'000u);
  EXPECT_EQ(link.agreed().capabilities, std::uint64_t{wire::kFunctionalLevel});
}

TEST(Handshake, KeepsTheDriversOwnLimitsWhenTheyAreSmaller) {
  wire::VersionInfo theirs;
  theirs.minor = 9;
  theirs.max_payload_bytes = 1u << 30;
  theirs.window_bytes = std::uint64_t{1} << 31;
  FakeBoard board(in_session([](FakeBoard&) {}, theirs));
  const Link link(board.take_socket(), {});
  EXPECT_EQ(link.agreed().minor, driver_version().minor);
  EXPECT_EQ(link.agreed().max_payload_bytes, driver_version().max_payload_bytes);
}

TEST(Handshake, SendsTheDriversVersionFirst) {
  wire::VersionInfo heard;
  {
    FakeBoard board([&heard](FakeBoard& self) {
      heard = self.shake_hands();
      self.drain();
    });
    const Link link(board.take_socket(), {});
  }
  EXPECT_EQ(heard, driver_version());
}

// A capture is given to others.
TEST(Handshake, TheAccessTokenFollowsTheVersionAndNoTapSeesIt) {
  std::optional<reference::Frame> heard;
  std::vector<reference::Frame> tapped;
  {
    FakeBoard board([&heard](FakeBoard& self) {
      heard = self.receive();
      self.refuse(*heard, wire::ErrorCode::kForbidden, "nobody gets in");
    });
    LinkOptions options;
    options.token = [](int) { return std::string("0123456789abcdef"); };
    options.tap = [&tapped](bool sent, auto header, std::span<const std::uint8_t> payload) {
      if (sent) tapped.push_back({*wire::decode_frame_header(header), {payload.begin(), payload.end()}});
    };
    EXPECT_THAT([&] { const Link link(board.take_socket(), options); },
                ThrowsMessage<OpenFailed>(HasSubstr("the board refuses access: nobody gets in")));
  }
  ASSERT_TRUE(heard.has_value());
  ASSERT_EQ(heard->payload.size(), wire::kVersionBytes + 16);
  EXPECT_EQ(std::string(heard->payload.begin() + wire::kVersionBytes, heard->payload.end()), "0123456789abcdef");
  heard->payload.resize(wire::kVersionBytes);
  ASSERT_EQ(tapped.size(), 1u);
  EXPECT_EQ(tapped[0].payload, heard->payload);
  EXPECT_EQ(tapped[0].header.size, wire::kVersionBytes) << "the frame is one without a token";
}

TEST(Handshake, TheDriverKnowsAllLevelsProgressAndHostRays) { EXPECT_EQ(driver_version().capabilities, 0x1Fu); }

TEST(Handshake, ALongAnswerIsRefusedByItsHeader) {
  for (const std::uint32_t size : {wire::kMaxHandshakePayload, wire::kMaxHandshakePayload + 1}) {
    const auto text = open_error([size](FakeBoard& self) {
      self.respond(*self.receive(), 0, std::vector<std::uint8_t>(size, 0xFF));
      self.drain();
    });
    const std::string refusal = "the peer announced a handshake of " + std::to_string(size) + " bytes, at most " +
                                std::to_string(wire::kMaxHandshakePayload) + " are allowed";
    EXPECT_EQ(text.find(refusal) != std::string::npos, size > wire::kMaxHandshakePayload) << text;
  }
}

TEST(Handshake, AVersionThatIsNoResponseIsRefused) {
  const auto text = open_error([](FakeBoard& self) {
    self.receive();
    self.send({wire::FrameType::kVersion}, std::vector<std::uint8_t>(wire::kVersionBytes));
    self.drain();
  });
  EXPECT_THAT(text, HasSubstr("another type"));
}

// Credit is handed back at half of the window: the board's largest frame must fit the other half.
TEST(Handshake, ADriversWindowHoldsTwoOfTheLargestFrames) {
  const auto opened = [](std::uint64_t window) {
    FakeBoard board([](FakeBoard& self) {
      wire::VersionInfo theirs;
      theirs.max_payload_bytes = 5000;
      self.shake_hands(theirs);
      self.drain();
    });
    LinkOptions options;
    options.mine.window_bytes = window;
    try {
      const Link link(board.take_socket(), options);
      return std::string("opened");
    } catch (const OpenFailed& error) {
      return std::string(error.what());
    }
  };
  EXPECT_EQ(opened(10'000), "opened");
  EXPECT_THAT(opened(9'998), HasSubstr("window is too small"));
}

TEST(Handshake, AnotherMajorVersionIsAVersionMismatchWithBothNumbers) {
  wire::VersionInfo theirs;
  theirs.major = 9;
  const auto text = open_error([&theirs](FakeBoard& self) { self.shake_hands(theirs); });
  EXPECT_EQ(text, "VersionMismatch: the board has another protocol version: major version 9, this driver's is " +
                      std::to_string(driver_version().major));
}

TEST(Handshake, ABoardThatRefusesTheVersionIsAVersionMismatchInItsOwnWords) {
  const auto text =
      open_error([](FakeBoard& self) { self.refuse(*self.receive(), wire::ErrorCode::kVersion, "I speak 2"); });
  EXPECT_THAT(text, HasSubstr("VersionMismatch"));
  EXPECT_THAT(text, HasSubstr("I speak 2"));
}

TEST(Handshake, ABoardWithAnOwnerIsBusy) {
  const auto text = open_error(
      [](FakeBoard& self) { self.refuse(*self.receive(), wire::ErrorCode::kBusy, "it serves another host"); });
  EXPECT_THAT(text, HasSubstr("BoardBusy"));
  EXPECT_THAT(text, HasSubstr("another host"));
}

TEST(Handshake, APeerThatClosesAtOnceIsNoBoard) {
  EXPECT_THAT(open_error([](FakeBoard& self) { self.receive(); }), HasSubstr("OpenFailed"));
  EXPECT_THAT(open_error([](FakeBoard&) {}), HasSubstr("OpenFailed"));
}

TEST(Handshake, APeerThatSpeaksAnotherProtocolIsNoBoard) {
  const auto text = open_error([](FakeBoard& self) {
    self.receive();
    self.send_bytes(bytes_of("HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\n\r\n"));
    self.drain();
  });
  EXPECT_THAT(text, HasSubstr("OpenFailed"));
  EXPECT_THAT(text, HasSubstr("not a frame"));
}

TEST(Handshake, APeerThatAnswersWithAnotherFrameIsNoBoard) {
  const auto text = open_error([](FakeBoard& self) {
    self.receive();
    self.complete(1, 0);
    self.drain();
  });
  EXPECT_THAT(text, HasSubstr("OpenFailed"));
  EXPECT_THAT(text, HasSubstr("another type"));
}

TEST(Handshake, AnAnswerOfFourGigabytesIsRefusedBeforeMemoryIsTaken) {
  const auto text = open_error([](FakeBoard& self) {
    wire::FrameHeader header;
    header.type = wire::FrameType::kVersion;
    header.flags = wire::kResponse;
    header.size = 0xFFFF'FFFF;
    std::array<std::uint8_t, wire::kFrameHeaderBytes> bytes{};
    encode(header, bytes);
    self.receive();
    self.send_bytes(bytes);
    self.drain();
  });
  EXPECT_THAT(text, HasSubstr("OpenFailed"));
  EXPECT_THAT(text, HasSubstr("4294967295"));
}

TEST(Handshake, AVersionThatIsCutShortIsRefused) {
  const auto text = open_error([](FakeBoard& self) {
    self.respond(*self.receive(), 0, bytes_of("\1\0\0\0"));
    self.drain();
  });
  EXPECT_THAT(text, HasSubstr("is truncated"));
}

TEST(Handshake, LimitsThatLeaveNoRoomForAFrameAreRefused) {
  wire::VersionInfo theirs;
  theirs.window_slots = 0;
  const auto text = open_error([&theirs](FakeBoard& self) {
    self.shake_hands(theirs);
    self.drain();
  });
  EXPECT_THAT(text, HasSubstr("limits"));
}

TEST(Handshake, ASilentPeerRunsIntoTheWatchdog) {
  const auto text = open_error([](FakeBoard& self) { self.drain(); }, std::chrono::milliseconds(50));
  EXPECT_THAT(text, HasSubstr("TimedOut"));
  EXPECT_THAT(text, HasSubstr("50 ms"));
}

}  // namespace
}  // namespace gicube
