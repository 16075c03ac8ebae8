// Credits of both directions.
#include "gicube/wire/memory_map.h"
#include "tools/conformance/host.h"

namespace gicube::conformance {
namespace {

// `sent`: how many frames the host has sent.
void send_credit(Host& host, std::uint32_t sent, std::uint32_t frames, std::uint64_t bytes) {
  FrameHeader header{FrameType::kCredit, wire::kPosted, sent};
  header.credit_slots = frames;
  header.credit_bytes = bytes;
  host.wire().send(header);
}

// Asks for credit until the board answers (P211). No frame other than credit may come meanwhile.
void nothing_comes(Host& host, std::uint32_t sent) {
  for (int tries = 0; tries < 100; ++tries) {
    host.wire().send(FrameType::kCredit, sent, 0, {});
    const auto frame = host.wire().receive();
    check(frame && frame->header.type == FrameType::kCredit, "expected no frame beyond the window, got one");
    if (frame->header.flags == wire::kResponse) return;
  }
  throw Failure("expected an answer to a query for credit, got other credit a hundred times");
}

wire::VersionInfo narrow(std::uint32_t frames, std::uint32_t payload) {
  wire::VersionInfo mine = host_version();
  mine.window_slots = frames;
  mine.max_payload_bytes = payload;
  mine.window_bytes = 2 * std::uint64_t{payload};
  return mine;
}

constexpr Case kCases[] = {
    {0, "credit.frames", "P601",
     [](Place& place) {
       Host host(place, narrow(1, 4096));
       for (std::uint32_t i = 0; i < 3; ++i) host.wire().send(FrameType::kRegisterRead, i, 0, words({reg::kId}));
       for (std::uint32_t i = 0; i < 3; ++i) {
         check_same("the answer after the credit for the one before", next_answer(host.wire()).header.id, i);
         if (i < 2) nothing_comes(host, 3);
         send_credit(host, 3, 1, 4);
       }
     }},
    {0, "credit.bytes", "P601",
     [](Place& place) {
       Host host(place, narrow(64, 4096));
       for (std::uint32_t i = 0; i < 3; ++i) {
         host.wire().send(FrameType::kMemoryRead, i, 0, long_words({wire::kReflectanceMap.base, 4096}));
       }
       for (std::uint32_t i = 0; i < 2; ++i) next_answer(host.wire());
       nothing_comes(host, 3);
       send_credit(host, 3, 2, 8192);
       check_same("the third answer, after credit came back", next_answer(host.wire()).header.id, 2);
     }},
    {0, "credit.returns", "P603",
     [](Host& host) {
       const std::uint32_t window = host.board().window_slots;
       for (std::uint32_t i = 0; i < window; ++i) host.wire().write_register(reg::kSeed, i);
       std::uint64_t frames = 0, bytes = 0;
       while (2 * frames < window) {
         const auto frame = host.wire().receive();
         check(frame && frame->header.type == FrameType::kCredit && frame->header.size == 0, "expected kCredit frames");
         frames += frame->header.credit_slots;
         bytes += frame->header.credit_bytes;
         check_same("bytes of the returned frames", bytes, 8 * frames);
       }
       check(frames <= window, "expected credit for at most {} frames, got {}", window, frames);
     }},
    {0, "credit.in_answers", "P603",
     [](Host& host) {
       for (int i = 0; i < 3; ++i) host.wire().write_register(reg::kSeed, 1);
       std::uint32_t frames = 0;
       for (int i = 0; i < 2; ++i) {
         frames += call(host.wire(), FrameType::kRegisterRead, 1, words({reg::kSeed})).header.credit_slots;
       }
       check(frames >= 4, "expected credit for the first 4 frames with the second answer, got it for {}", frames);
     }},
    {0, "credit.overrun", "P604",
     [](Place& place) {
       Host host(place, narrow(1, 4096));  // the board can't go on after its first answer
       const std::uint32_t more = host.board().window_slots + 8;
       for (std::uint32_t i = 0; i < more; ++i) host.wire().send(FrameType::kRegisterRead, i, 0, words({reg::kId}));
       host.ends(ErrorCode::kProtocol);
     }},
    {0, "credit.too_much", "P604",
     [](Place& place) {
       for (const auto& [frames, bytes] : {std::pair{2u, 8u}, std::pair{1u, 5u}, std::pair{1u, 0u}}) {
         Host host(place);
         call(host.wire(), FrameType::kRegisterRead, 1, words({reg::kId}));
         send_credit(host, 1, frames, bytes);
         host.ends(ErrorCode::kProtocol);
       }
     }},
    {0, "credit.query", "P211",
     [](Host& host) {
       for (const std::uint32_t id : {1u, 2u}) call(host.wire(), FrameType::kRegisterRead, id, words({reg::kId}));
       host.wire().send(FrameType::kCredit, 2, 0, {});
       const auto answer = host.wire().receive();
       check(answer && answer->header.type == FrameType::kCredit, "expected kCredit");
       check_same("its flags", answer->header.flags, wire::kResponse);
       check_same("the last number that the board used", answer->header.id, 2);
       check_same("its own number", answer->header.sequence, 0);
     }},
    {0, "credit.missing", "P210",
     [](Host& host) {
       host.wire().send(FrameType::kCredit, 1, wire::kPosted, {});
       host.ends(ErrorCode::kCorrupted);
     }},
};

}  // namespace

std::span<const Case> credit_cases() { return kCases; }

}  // namespace gicube::conformance
