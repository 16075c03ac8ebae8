// The form, the numbers and the order of frames.
#include <array>

#include "gicube/wire/checksum.h"
#include "gicube/wire/memory_map.h"
#include "tools/conformance/host.h"

namespace gicube::conformance {
namespace {

// A frame's bytes with a right size and checksum. The caller may have set any other field to a wrong value.
Bytes sealed(FrameHeader header, const Bytes& payload) {
  Bytes bytes(wire::kFrameHeaderBytes);
  header.size = static_cast<std::uint32_t>(payload.size());
  wire::encode_sealed(header, payload, std::span(bytes).first<wire::kFrameHeaderBytes>());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  return bytes;
}

Bytes read_id(std::uint32_t sequence) {
  FrameHeader header{FrameType::kRegisterRead, 0, 5};
  header.sequence = sequence;
  return sealed(header, words({reg::kId}));
}

// These bytes, sent first after a handshake, must end the connection with this error.
void ended_by(Place& place, const Bytes& bytes, ErrorCode error, std::optional<std::uint32_t> id = {}) {
  Host host(place);
  host.wire().send_bytes(bytes);
  host.ends(error, id);
}

void ended_by(Place& place, FrameType type, std::uint16_t flags, const Bytes& payload) {
  FrameHeader header{type, flags, 4711};
  header.sequence = wire::is_free(type) ? 0 : 1;
  ended_by(place, sealed(header, payload), ErrorCode::kProtocol, 4711);
}

constexpr Case kCases[] = {
    {0, "frame.checksum", "P305",
     [](Place& place) {
       for (const std::size_t damaged : {std::size_t{24}, wire::kFrameHeaderBytes, wire::kFrameHeaderBytes - 1}) {
         Bytes bytes = read_id(1);
         bytes[damaged] ^= 4;
         ended_by(place, bytes, ErrorCode::kCorrupted);
       }
     }},
    {0, "frame.magic", "P305",
     [](Place& place) {
       Bytes bytes = read_id(1);
       bytes[0] ^= 1;
       ended_by(place, bytes, ErrorCode::kCorrupted);
       FrameHeader unknown{static_cast<FrameType>(77)};
       unknown.sequence = 1;
       ended_by(place, sealed(unknown, {}), ErrorCode::kCorrupted);
     }},
    {0, "frame.gap", "P305", [](Place& place) { ended_by(place, read_id(2), ErrorCode::kCorrupted); }},
    {0, "frame.again", "P208",
     [](Host& host) {
       host.wire().send_bytes(read_id(1));
       host.wire().send_bytes(read_id(1));
       host.wire().send_bytes(read_id(2));
       for (const std::uint32_t number : {1u, 2u}) {
         check_same("the next answer's number", next_answer(host.wire()).header.sequence, number);
       }
       host.wire().send(FrameType::kCredit, 2, 0, {});
       const auto answer = host.wire().receive();
       check(answer && answer->header.type == FrameType::kCredit, "expected no answer to a repeated frame, got one");
     }},
    {0, "frame.size", "P302",
     [](Host& host) {
       FrameHeader header{FrameType::kMemoryWrite, wire::kPosted, 6};
       header.size = host.max_payload() + 1;
       header.sequence = 1;
       Bytes bytes(wire::kFrameHeaderBytes);
       wire::encode(header, std::span(bytes));
       host.wire().send_bytes(bytes);  // none of its payload
       host.ends(ErrorCode::kTooLarge);
     }},
    {0, "frame.largest", "P105",
     [](Place& place) {
       wire::VersionInfo mine = host_version();
       mine.max_payload_bytes = 8192;
       Host host(place, mine);
       host.write_memory(wire::kReflectanceMap.base, Bytes(8192, 1));
       check(host.read_memory(wire::kReflectanceMap.base, 8192) == Bytes(8192, 1), "expected 8192 bytes back");
       FrameHeader header{FrameType::kMemoryWrite, wire::kPosted, 6};
       header.sequence = 99;
       host.wire().send_bytes(sealed(header, Bytes(8193)));
       host.ends(ErrorCode::kTooLarge);
     }},
    {0, "frame.flags", "P308",
     [](Place& place) {
       ended_by(place, FrameType::kRegisterRead, wire::kPosted, words({reg::kId}));
       ended_by(place, FrameType::kRegisterRead, wire::kResponse, words({reg::kId}));
       ended_by(place, FrameType::kRegisterWrite, 0, words({reg::kSeed, 1}));
       ended_by(place, FrameType::kCommand, 0, words({1}));
     }},
    {0, "frame.type", "P308",
     [](Place& place) {
       ended_by(place, FrameType::kCompletion, wire::kPosted, {});
       ended_by(place, FrameType::kProgress, wire::kPosted, words({1, 2}));
       ended_by(place, FrameType::kVersion, 0, wire::encoded(host_version()));
     }},
    {0, "frame.error", "P311",
     [](Place& place) {
       FrameHeader header{FrameType::kRegisterRead, 0, 12};
       header.sequence = 1;
       header.error = ErrorCode::kBadValue;
       ended_by(place, sealed(header, words({reg::kId})), ErrorCode::kProtocol, 12);
     }},
    {0, "frame.response", "P306",
     [](Host& host) {
       for (const std::uint32_t id : {0u, 1u, 0x8000'0000u, 0xFFFF'FFFFu}) {
         const RawFrame answer = call(host.wire(), FrameType::kRegisterRead, id, words({reg::kId}));
         check_same("the response's id", answer.header.id, id);
         check_same("the response's type", answer.header.type, FrameType::kRegisterRead);
         check_same("the response's flags", answer.header.flags, wire::kResponse);
         check(answer.payload == words({wire::kIdValue}), "expected ID in the response");
       }
     }},
    {0, "frame.numbers", "P304",
     [](Host& host) {
       for (std::uint32_t number = 1; number <= 5; ++number) {
         const RawFrame answer = call(host.wire(), FrameType::kRegisterRead, 3, words({reg::kId}));
         check_same("the answer's number", answer.header.sequence, number);
       }
     }},
    {0, "frame.order", "P303",
     [](Host& host) {
       for (std::uint32_t i = 0; i < 12; ++i) {
         host.wire().write_register(reg::kSeed, 1000 + i);
         host.wire().send(FrameType::kRegisterRead, i, 0, words({reg::kSeed}));
       }
       for (std::uint32_t i = 0; i < 12; ++i) {
         const RawFrame answer = next_answer(host.wire());
         check(answer.header.id == i && answer.payload == words({1000 + i}),
               "expected the answers in the order of the requests, number {} is another", i);
       }
     }},
    {0, "frame.pieces", "P301",
     [](Host& host) {
       Bytes both = read_id(1);
       const Bytes second = read_id(2);
       both.insert(both.end(), second.begin(), second.end());
       for (const std::uint8_t byte : std::span(both).first(60)) host.wire().send_bytes(std::array{byte});
       host.wire().send_bytes(std::span(both).subspan(60));
       for (int i = 0; i < 2; ++i) {
         check(next_answer(host.wire()).payload == words({wire::kIdValue}), "expected ID from a frame in pieces");
       }
     }},
    {0, "frame.payload", "P312",
     [](Host& host) {
       const std::pair<FrameType, std::size_t> wrong[] = {{FrameType::kRegisterRead, 3}, {FrameType::kRegisterRead, 8},
                                                          {FrameType::kConfigRead, 0},   {FrameType::kConfigWrite, 4},
                                                          {FrameType::kMemoryRead, 8},   {FrameType::kWait, 3},
                                                          {FrameType::kWait, 8},         {FrameType::kCancel, 0}};
       for (const auto& [type, size] : wrong) host.refused_request(type, Bytes(size), ErrorCode::kBadValue);
       host.post(FrameType::kRegisterWrite, words({reg::kSeed}));
       check_same("SEED", host.read_register(reg::kSeed), 0);
     }},
    {0, "error.text", "P701",
     [](Host& host) {
       const RawFrame answer = host.refused_request(FrameType::kWait, words({12345}), ErrorCode::kBadValue);
       check(answer.text().find("12345") != std::string::npos, "expected a text that names ticket 12345, got \"{}\"",
             answer.text());
     }},
    {0, "error.last", "P702",
     [](Host& host) {
       host.read_register(reg::kId);
       const std::uint32_t id = host.post(FrameType::kCompletion, {});
       host.ends(ErrorCode::kProtocol, id);
     }},
};

}  // namespace

std::span<const Case> frame_cases() { return kCases; }

}  // namespace gicube::conformance
