// Sessions that outlive their connections, and checkpoints.
#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"

namespace gicube::conformance {
namespace {

using wire::VersionInfo;

// The next connection of a session. The client has taken `taken` frames, and the board has returned credit for
// `consumed` of its frames.
struct Resumed {
  RawClient client;
  VersionInfo board;

  Resumed(Place& place, std::uint64_t session, std::uint32_t taken, std::uint32_t consumed) : client(place.connect()) {
    VersionInfo mine = host_version();
    mine.session = session;
    mine.taken = taken;
    mine.consumed = consumed;
    const RawFrame answer = shake_hands(client, mine);
    check(answer.header.error == ErrorCode::kNone, "expected the session to resume, got error {}: {}",
          fmt::underlying(answer.header.error), answer.text());
    board = wire::decode<VersionInfo>(answer.payload);
    check_same("the resumed session", board.session, session);
  }
  ~Resumed() { client.send(FrameType::kVersion, 0, wire::kPosted, {}); }
};

void expect_seed(RawClient& client, std::uint32_t value) {
  check(call(client, FrameType::kRegisterRead, 9, words({reg::kSeed})).payload == words({value}), "expected SEED {}",
        value);
}

using Step = wire::CheckpointStep;

Bytes checkpoint(Host& host, Step step, const Bytes& data = {}) {
  Bytes payload = words({static_cast<std::uint32_t>(step)});
  payload.insert(payload.end(), data.begin(), data.end());
  return host.request(FrameType::kCheckpoint, payload);
}

constexpr Case kCases[] = {
    {5, "session.resumes", "P202",
     [](Host& host) {
       host.write_register(reg::kSeed, 77);
       host.read_register(reg::kSeed);
       host.cut();
       Resumed next(host.place(), host.board().session, 1, 0);
       check_same("frames that the board took", next.board.taken, 2u);
       next.client.continue_from(2);
       expect_seed(next.client, 77);
     }},
    {5, "session.answers_again", "P207",
     [](Host& host) {
       for (std::uint32_t i = 0; i < 3; ++i) {
         call(host.wire(), FrameType::kRegisterRead, 10 + i, words({reg::kId}));
       }
       host.cut();
       Resumed next(host.place(), host.board().session, 1, 0);  // as if only the first answer had come
       for (std::uint32_t i = 1; i < 3; ++i) {
         const RawFrame answer = next_answer(next.client);
         check_same("the repeated answer's id", answer.header.id, 10 + i);
         check_same("its number", answer.header.sequence, 1 + i);
         check(answer.payload == words({wire::kIdValue}), "expected the same bytes again");
       }
     }},
    {5, "session.damaged", "P305",
     [](Host& host) {
       host.write_register(reg::kSeed, 5);
       host.wire().send_bytes(Bytes(wire::kFrameHeaderBytes, 0x55));
       host.ends(ErrorCode::kCorrupted);
       Resumed next(host.place(), host.board().session, 0, 0);
       check_same("frames that the board took", next.board.taken, 1u);
       next.client.continue_from(1);
       expect_seed(next.client, 5);
     }},
    {5, "session.once", "P208",
     [](Host& host) {
       host.write_register(reg::kSeed, 1);
       const std::uint64_t before = host.now;
       host.read_register(reg::kSeed);
       const std::uint64_t access = host.now - before;
       host.cut();
       Resumed next(host.place(), host.board().session, 1, 0);
       next.client.write_register(reg::kSeed, 99);  // numbers 1 and 2 again: dropped
       next.client.send(FrameType::kRegisterRead, 8, 0, words({reg::kSeed}));
       FrameHeader header{FrameType::kRegisterRead, 0, 9};
       header.time_ps = host.now;
       next.client.send(header, words({reg::kSeed}));
       const RawFrame answer = next_answer(next.client);
       check_same("the id of the answer to the new frame", answer.header.id, 9);
       check(answer.payload == words({1}), "expected SEED as the first time");
       check(answer.header.time_ps <= host.now + access, "expected at most {} ps, got {}", host.now + access,
             answer.header.time_ps);
     }},
    {5, "session.new_client", "P203",
     [](Host& host) {
       host.write_register(reg::kSeed, 5);
       host.read_register(reg::kSeed);
       host.cut();
       Host other(host.place());
       check_same("SEED of another client's session", other.read_register(reg::kSeed), 0u);
       RawClient late = host.place().connect();
       VersionInfo mine = host_version();
       mine.session = host.board().session;
       check_same("the error for the former session", static_cast<int>(shake_hands(late, mine).header.error),
                  static_cast<int>(ErrorCode::kNoSession));
     }},
    {5, "session.command", "P202",
     [](Host& host) {
       const Volume volume(host, {9, 9, 9});
       const Bytes command = wire::encoded(along(2, true, volume, 64, 64, 0.1));
       host.wire().send(FrameType::kCommand, 600, wire::kPosted, command);
       const std::uint32_t number = host.window().sent() + 1;
       VersionInfo mine;
       host.window().announce(mine);
       host.cut();
       Resumed next(host.place(), host.board().session, mine.taken, mine.consumed);
       next.client.continue_from(next.board.taken);
       if (next.board.taken < number) next.client.send(FrameType::kCommand, 600, wire::kPosted, command);
       next.client.send(FrameType::kWait, 700, 0, words({600}));
       const RawFrame done = next_answer(next.client);
       check_same("the type of a completion", done.header.type, FrameType::kCompletion);
       check_same("its id", done.header.id, 600);
     }},
    {5, "checkpoint.restores", "P504",
     [](Place& place) {
       Bytes saved;
       {
         Host host(place);
         host.write_register(reg::kSeed, 321);
         host.write_memory(wire::kReflectanceMap.base, {1, 2, 3, 4});
         host.read_register(reg::kSeed);
         checkpoint(host, Step::kBegin);
         checkpoint(host, Step::kWrite, {9, 8, 7});
         const Bytes size = checkpoint(host, Step::kTake);
         check_same("bytes of the answer", size.size(), 8);
         const std::uint64_t bytes = wire::load<std::uint64_t>(size, 0), piece = host.max_payload() / 2;
         for (std::uint64_t at = 0; at < bytes; at += piece) {
           const Bytes part = checkpoint(host, Step::kRead, long_words({at, std::min(piece, bytes - at)}));
           saved.insert(saved.end(), part.begin(), part.end());
         }
         check_same("bytes of the checkpoint", saved.size(), bytes);
       }
       Host host(place);
       checkpoint(host, Step::kBegin);
       for (std::span rest(saved); !rest.empty();) {
         const auto part = rest.first(std::min<std::size_t>(rest.size(), host.max_payload() / 2));
         checkpoint(host, Step::kWrite, Bytes(part.begin(), part.end()));
         rest = rest.subspan(part.size());
       }
       const Bytes went_on = checkpoint(host, Step::kGoOn);
       check_same("bytes of the answer", went_on.size(), 24);
       check_same("bytes of the driver's part", wire::load<std::uint64_t>(went_on, 0), 3u);
       check(checkpoint(host, Step::kRead, long_words({0, 3})) == Bytes{9, 8, 7}, "expected the driver's part");
       host.now = 1'000'000'000;
       check_same("SEED", host.read_register(reg::kSeed), 321u);
       check(host.read_memory(wire::kReflectanceMap.base, 4) == Bytes{1, 2, 3, 4}, "expected the saved table");
     }},
    {5, "checkpoint.refused", "P505",
     [](Host& host) {
       host.write_register(reg::kSeed, 4);
       checkpoint(host, Step::kBegin);
       checkpoint(host, Step::kWrite, Bytes(100, 7));
       host.refused_request(FrameType::kCheckpoint, words({static_cast<std::uint32_t>(Step::kGoOn)}),
                            ErrorCode::kBadValue);
       check_same("SEED", host.read_register(reg::kSeed), 4u);
     }},
};

}  // namespace

std::span<const Case> session_cases() { return kCases; }

}  // namespace gicube::conformance
