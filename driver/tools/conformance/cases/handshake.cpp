// The handshake, and the ownership of the board.
#include <array>

#include "tools/conformance/case.h"
#include "tools/conformance/host.h"

namespace gicube::conformance {
namespace {

using wire::VersionInfo;

// The board must answer this version frame with an error and a text, and close the connection.
void refuses(Place& place, const VersionInfo& mine, ErrorCode error) {
  RawClient client = place.connect();
  const RawFrame answer = shake_hands(client, mine);
  check_same("the refusal's error", answer.header.error, error);
  check(!answer.payload.empty(), "expected a text with the refusal, got none");
  check(!client.receive().has_value(), "expected the board to close a refused connection");
}

VersionInfo with(auto VersionInfo::*field, auto value) {
  VersionInfo mine = host_version();
  mine.*field = value;
  return mine;
}

constexpr Case kCases[] = {
    {0, "version.answer", "P103",
     [](Place& place) {
       const Host host(place);
       const VersionInfo& board = host.board();
       check_same("major version", board.major, wire::kMajorVersion);
       check(board.max_payload_bytes >= wire::kMaxHandshakePayload, "largest payload: expected at least 4096, got {}",
             board.max_payload_bytes);
       check(board.window_slots >= 1 && board.window_bytes >= 2 * std::uint64_t{host.max_payload()},
             "window: expected one frame and two payloads or more, got {} frames and {} bytes", board.window_slots,
             board.window_bytes);
       check((board.capabilities & (wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel)) != 0,
             "capabilities: expected a level, got 0x{:x}", board.capabilities);
     }},
    {0, "version.token", "P201",
     [](Place& place) {
       std::array<std::uint64_t, 3> tokens{};
       for (std::uint64_t& token : tokens) token = Host(place).board().session;
       check(tokens[0] != 0 && tokens[0] != tokens[1] && tokens[1] != tokens[2] && tokens[0] != tokens[2],
             "expected three tokens, none 0, got {}, {}, {}", tokens[0], tokens[1], tokens[2]);
     }},
    {0, "version.major", "P104",
     [](Place& place) {
       refuses(place, with(&VersionInfo::major, std::uint16_t{1}), ErrorCode::kVersion);
       refuses(place, with(&VersionInfo::major, std::uint16_t{3}), ErrorCode::kVersion);
     }},
    {0, "version.minor", "P105",
     [](Place& place) {
       for (const std::uint16_t minor : {std::uint16_t{0}, std::uint16_t{99}}) {
         Host host(place, with(&VersionInfo::minor, minor));
         check_same("ID", host.read_register(reg::kId), wire::kIdValue);
       }
     }},
    {0, "version.limits", "P106",
     [](Place& place) {
       refuses(place, with(&VersionInfo::max_payload_bytes, std::uint32_t{4095}), ErrorCode::kProtocol);
       refuses(place, with(&VersionInfo::window_slots, std::uint32_t{0}), ErrorCode::kProtocol);
       VersionInfo narrow = with(&VersionInfo::max_payload_bytes, std::uint32_t{4096});
       narrow.window_bytes = 8191;
       refuses(place, narrow, ErrorCode::kProtocol);
       narrow.window_bytes = 8192;
       check_same("ID", Host(place, narrow).read_register(reg::kId), wire::kIdValue);
     }},
    {0, "version.first", "P104",
     [](Place& place) {
       RawClient client = place.connect();
       client.send(FrameType::kRegisterRead, 1, 0, words({reg::kId}));
       Host::ends(client, ErrorCode::kProtocol);
     }},
    {0, "version.large", "P102",
     [](Place& place) {
       RawClient client = place.connect();
       client.send(FrameType::kVersion, 0, 0, Bytes(4097));
       Host::ends(client, ErrorCode::kTooLarge);
     }},
    {0, "version.no_session", "P104",
     [](Place& place) {
       refuses(place, with(&VersionInfo::session, std::uint64_t{0x1234567}), ErrorCode::kNoSession);
     }},
    {0, "owner.busy", "P104",
     [](Place& place) {
       Host owner(place);
       owner.write_register(reg::kSeed, 7);
       refuses(place, with(&VersionInfo::wait_ms, std::uint32_t{0}), ErrorCode::kBusy);
       check_same("SEED after another client was refused", owner.read_register(reg::kSeed), 7);
     }},
    {0, "owner.goodbye", "P203",
     [](Place& place) {
       const std::uint64_t session = Host(place).board().session;
       const Host next(place);
       check(next.board().session != session, "expected a new session after a goodbye, got the former one");
     }},
    {0, "owner.new_board", "P108",
     [](Place& place) {
       {
         Host former(place);
         former.write_register(reg::kSeed, 9);
         former.write_register(reg::kVolumeX, 1);  // too small
         check_same("STATUS", former.read_register(reg::kStatus), wire::kStatusBadValue);
       }
       Host host(place);
       check_same("SEED of a new session", host.read_register(reg::kSeed), 0);
       check_same("STATUS of a new session", host.read_register(reg::kStatus), 0);
       check(host.now < 10'000'000, "expected a clock that begins with the session, got {} ps", host.now);
     }},
    {5, "owner.waits", "P110",
     [](Place& place) {
       auto owner = std::make_unique<Host>(place);
       RawClient first = place.connect(), second = place.connect();
       Bytes hello = wire::encoded(host_version());
       first.send(FrameType::kVersion, 0, 0, hello);
       RawClient probe = place.connect();  // served after `first` was read
       const RawFrame busy = shake_hands(probe, with(&VersionInfo::wait_ms, 0u));
       check_same("the error of a client that does not wait", busy.header.error, ErrorCode::kBusy);
       second.send(FrameType::kVersion, 0, 0, hello);
       owner.reset();
       const auto answer = first.receive();
       check(answer && answer->header.error == ErrorCode::kNone, "expected the first in the line to get the board");
       first.send(FrameType::kVersion, 0, wire::kPosted, {});
       const auto next = second.receive();
       check(next && next->header.error == ErrorCode::kNone, "expected the second in the line to get the board next");
       second.send(FrameType::kVersion, 0, wire::kPosted, {});
     }},
    {5, "owner.force", "P110",
     [](Place& place) {
       Host owner(place);
       RawClient thief = place.connect();
       const RawFrame answer = shake_hands(thief, with(&VersionInfo::flags, std::uint32_t{wire::kForce}));
       check_same("the error of kForce", answer.header.error, ErrorCode::kNone);
       owner.ends(ErrorCode::kTaken);
       thief.send(FrameType::kVersion, 0, wire::kPosted, {});
     }},
    {5, "version.silence", "P107",
     [](Place& place) {
       RawClient client = place.connect();
       const auto begin = std::chrono::steady_clock::now();
       while (client.receive().has_value()) {
       }
       const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
       check(seconds > 4.5, "expected five seconds, the board closed after {}", seconds);
     }},
};

}  // namespace

std::span<const Case> handshake_cases() { return kCases; }

}  // namespace gicube::conformance
