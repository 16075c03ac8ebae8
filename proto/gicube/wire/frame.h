// Frames of the data plane: what one socket message between driver and board looks like.
//
//   byte  size  field
//      0     4  magic          'G' 'I' 'C' 'U'
//      4     2  type           FrameType
//      6     2  flags          FrameFlag
//      8     4  id             chosen by the requester; the response carries it back
//     12     4  size           payload bytes that follow; checked against the negotiated limit before memory is taken
//     16     4  error          ErrorCode; 0 = none
//     20     4  credit_slots   frames that the sender has consumed since it last said so
//     24     8  time_ps        requester: host clock when issued; board: simulated time of the event
//     32     8  credit_bytes   payload bytes that the sender has consumed since it last said so
//     40     4  sequence       counts the frames of one direction that take credit, from 1, modulo 2^32; 0 on all others
//     44     4  checksum       CRC-32C of the header, this field being 0, and the payload (checksum.h)
//
// Little endian. The frame is a model's envelope, not bus traffic: the bus model charges payloads (docs/reference/protocol.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

inline constexpr std::uint32_t kFrameMagic = 0x55434947;
inline constexpr std::size_t kFrameHeaderBytes = 48;

enum class FrameType : std::uint16_t {
  kVersion = 1,       // first in both directions: VersionInfo
  kCredit = 2,        // posted; the header's credit fields count, and id: the last sequence number that its sender used
  kConfigRead = 3,    // PCI configuration space: u32 offset -> u32 value
  kConfigWrite = 4,   // u32 offset, u32 value -> empty
  kRegisterRead = 5,  // BAR0: u32 offset -> u32 value; unmapped reads give all ones
  kRegisterWrite = 6,  // posted: u32 offset, u32 value
  kMemoryWrite = 7,    // posted: u64 address, bytes (memory_map.h)
  kMemoryRead = 8,     // u64 address, u64 length -> bytes; the board writes them to the host as bus master
  kCommand = 9,        // posted: a DSP command (command.h); its frame id is the ticket
  kCompletion = 10,    // board to host, id = ticket: result of a command, pushed in simulated-time order
  kWait = 11,          // u32 ticket -> empty, once that command has completed; the host is blocked until then.
                       // u32 ticket, u64 deadline (ps) -> kDeadline at that time if it has not completed by then
  kPoll = 12,          // -> empty, after every completion not later than time_ps has been pushed
  kCounters = 13,      // -> counter list (counter_list.h)
  kProgress = 14,      // board to host, id = ticket: u32 parts done, u32 parts in all; costs no simulated time
  kCancel = 15,        // u32 ticket -> u32: 1 = the command's turn had not begun, it will complete with kCancelled; 0
};

enum FrameFlag : std::uint16_t {
  kResponse = 1 << 0,
  kPosted = 1 << 1,  // no response will follow
};

// These take no credit and have no sequence number: they are not sent again when a session is resumed.
constexpr bool is_free(FrameType type) {
  return type == FrameType::kVersion || type == FrameType::kCredit || type == FrameType::kProgress;
}

// The numbers are stable: they stand in recorded traffic and in applications' logs.
enum class ErrorCode : std::uint32_t {
  kNone = 0,
  kProtocol = 1,     // malformed frame; the session is closed
  kVersion = 2,      // major versions differ; the session is closed
  kTooLarge = 3,     // a length beyond the negotiated limit; the session is closed
  kBusy = 4,         // the board has an owner; the session is closed
  kBadAddress = 5,   // no register or memory there
  kBadValue = 6,     // a field of a command or register out of its range
  kUnsupported = 7,  // this board or fidelity level can't do that
  kCancelled = 8,    // the board shuts down
  kInternal = 9,     // a fault of the board itself
  kCorrupted = 10,   // a wrong checksum, or a frame is missing; the connection is closed, the session may be resumed
  kDeadline = 11,    // the deadline in device time passed first
  kMemory = 12,      // the RDRAM reported an error that it could not correct
  kTaken = 13,       // another client took the board by force; the session is closed
  kNoSession = 14,   // there is no such session to resume; the connection is closed
};

struct FrameHeader {
  FrameType type{};
  std::uint16_t flags = 0;
  std::uint32_t id = 0;
  std::uint32_t size = 0;
  ErrorCode error = ErrorCode::kNone;
  std::uint32_t credit_slots = 0;
  std::uint64_t time_ps = 0;
  std::uint64_t credit_bytes = 0;
  std::uint32_t sequence = 0;
  std::uint32_t checksum = 0;

  friend constexpr bool operator==(const FrameHeader&, const FrameHeader&) = default;
};

inline void encode(const FrameHeader& header, std::span<std::uint8_t, kFrameHeaderBytes> out) {
  store(out, 0, kFrameMagic);
  store(out, 4, static_cast<std::uint16_t>(header.type));
  store(out, 6, header.flags);
  store(out, 8, header.id);
  store(out, 12, header.size);
  store(out, 16, static_cast<std::uint32_t>(header.error));
  store(out, 20, header.credit_slots);
  store(out, 24, header.time_ps);
  store(out, 32, header.credit_bytes);
  store(out, 40, header.sequence);
  store(out, 44, header.checksum);
}

// Nothing if the magic or the type is wrong: what follows in the stream can't be trusted then.
inline std::optional<FrameHeader> decode_frame_header(std::span<const std::uint8_t, kFrameHeaderBytes> in) {
  if (load<std::uint32_t>(in, 0) != kFrameMagic) return std::nullopt;
  const auto type = load<std::uint16_t>(in, 4);
  if (type < static_cast<std::uint16_t>(FrameType::kVersion) || type > static_cast<std::uint16_t>(FrameType::kCancel)) {
    return std::nullopt;
  }
  FrameHeader header;
  header.type = static_cast<FrameType>(type);
  header.flags = load<std::uint16_t>(in, 6);
  header.id = load<std::uint32_t>(in, 8);
  header.size = load<std::uint32_t>(in, 12);
  header.error = static_cast<ErrorCode>(load<std::uint32_t>(in, 16));
  header.credit_slots = load<std::uint32_t>(in, 20);
  header.time_ps = load<std::uint64_t>(in, 24);
  header.credit_bytes = load<std::uint64_t>(in, 32);
  header.sequence = load<std::uint32_t>(in, 40);
  header.checksum = load<std::uint32_t>(in, 44);
  return header;
}

// How far `sequence` is after `taken`: 1 = the next, more = frames are missing, 0 or less = a frame that was taken before.
constexpr std::int32_t sequence_step(std::uint32_t taken, std::uint32_t sequence) {
  return static_cast<std::int32_t>(sequence - taken);
}

inline constexpr std::uint16_t kMajorVersion = 2;
inline constexpr std::uint16_t kMinorVersion = 0;
inline constexpr std::uint32_t kMaxHandshakePayload = 4096;  // limit before a version is agreed

enum Capability : std::uint64_t {
  kFunctionalLevel = 1 << 0,
  kApproximateLevel = 1 << 1,
  kCycleLevel = 1 << 2,
  kProgressFrames = 1 << 3,
  kHostRays = 1 << 4,
};

enum VersionFlag : std::uint32_t {
  kForce = 1 << 0,  // client: end the session of whoever owns the board, and take it
};

// Payload of kVersion. Each side says what it speaks and how much it can take; the smaller minor version, payload limit
// and the common capabilities hold for the session. The credit fields are each sender's own receive window.
//
//   byte  size  field
//      0     2  major
//      2     2  minor
//      4     4  max_payload_bytes
//      8     4  window_slots
//     12     4  flags            VersionFlag
//     16     8  window_bytes
//     24     8  capabilities
//     32     8  session          client: the session to resume, 0 = a new one; board: the session's token, never 0
//     40     4  taken            last sequence number that was taken from the peer in this session; 0 in a new one
//     44     4  consumed         last one whose credit the peer may use again, not later than `taken`
//     48     4  wait_ms          client: how long it will wait for the board while that has an owner; board: 0
//     52     4  reserved, 0
inline constexpr std::size_t kVersionBytes = 56;

struct VersionInfo {
  std::uint16_t major = kMajorVersion;
  std::uint16_t minor = kMinorVersion;
  std::uint32_t max_payload_bytes = 4u << 20;
  std::uint32_t window_slots = 64;
  std::uint64_t window_bytes = 16u << 20;
  std::uint64_t capabilities = 0;
  std::uint32_t flags = 0;
  std::uint64_t session = 0;
  std::uint32_t taken = 0;
  std::uint32_t consumed = 0;
  std::uint32_t wait_ms = 0;

  friend constexpr bool operator==(const VersionInfo&, const VersionInfo&) = default;
};

inline void encode(const VersionInfo& info, std::span<std::uint8_t, kVersionBytes> out) {
  store(out, 0, info.major);
  store(out, 2, info.minor);
  store(out, 4, info.max_payload_bytes);
  store(out, 8, info.window_slots);
  store(out, 12, info.flags);
  store(out, 16, info.window_bytes);
  store(out, 24, info.capabilities);
  store(out, 32, info.session);
  store(out, 40, info.taken);
  store(out, 44, info.consumed);
  store(out, 48, info.wait_ms);
  store(out, 52, std::uint32_t{0});
}

inline VersionInfo decode_version(std::span<const std::uint8_t, kVersionBytes> in) {
  VersionInfo info;
  info.major = load<std::uint16_t>(in, 0);
  info.minor = load<std::uint16_t>(in, 2);
  info.max_payload_bytes = load<std::uint32_t>(in, 4);
  info.window_slots = load<std::uint32_t>(in, 8);
  info.flags = load<std::uint32_t>(in, 12);
  info.window_bytes = load<std::uint64_t>(in, 16);
  info.capabilities = load<std::uint64_t>(in, 24);
  info.session = load<std::uint64_t>(in, 32);
  info.taken = load<std::uint32_t>(in, 40);
  info.consumed = load<std::uint32_t>(in, 44);
  info.wait_ms = load<std::uint32_t>(in, 48);
  return info;
}

// What both sides hold to after the handshake; nothing if the majors differ or a peer could never take a frame. A window
// holds two of the largest frames: credit is due at half a window, so what is not yet due never keeps a frame waiting.
inline std::optional<VersionInfo> agree(const VersionInfo& mine, const VersionInfo& theirs) {
  if (mine.major != theirs.major) return std::nullopt;
  VersionInfo agreed = mine;
  if (theirs.minor < agreed.minor) agreed.minor = theirs.minor;
  if (theirs.max_payload_bytes < agreed.max_payload_bytes) agreed.max_payload_bytes = theirs.max_payload_bytes;
  agreed.capabilities &= theirs.capabilities;
  const bool usable = agreed.max_payload_bytes >= kMaxHandshakePayload && theirs.window_slots >= 1 &&
                      theirs.window_bytes >= 2 * std::uint64_t{agreed.max_payload_bytes};
  if (!usable) return std::nullopt;
  return agreed;
}

}  // namespace gicube::wire
