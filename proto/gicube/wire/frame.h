// Frames of the data plane: what one socket message between driver and board looks like. A header (its bytes: README.md), then
// `size` bytes of payload.
//
// A frame is a model's envelope, not bus traffic: the bus model charges payloads (docs/reference/protocol.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr std::uint32_t kFrameMagic = 0x55434947;

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
  kCheckpoint = 16,  // u32 CheckpointStep and what it needs; takes no simulated time, and is no message of a fault plan
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
  kForbidden = 15,   // no token, a wrong one, or one without the right; the connection is closed
};

// What a kCheckpoint frame asks for. The session has one buffer for checkpoints, empty at first; docs/reference/protocol.md has the order.
enum class CheckpointStep : std::uint32_t {
  kBegin = 1,  // empties the buffer -> empty
  kWrite = 2,  // bytes, which are appended to it -> empty
  kTake = 3,   // what was written is the driver's part: the buffer becomes the board's checkpoint -> u64 its bytes
  kRead = 4,   // u64 offset, u64 length -> bytes of it
  kGoOn =
      5,  // the board becomes the one that the buffer is a checkpoint of, or if that is empty the one that its process began with
  // (gicube-board --restore) -> WentOn; the buffer is the driver's part then
};

// What may differ from the board that was saved.
struct WentOn {
  std::uint64_t driver_bytes = 0;  // 0: the checkpoint has no driver's part
  std::uint64_t config_hash = 0;
  std::uint32_t fidelity = 0;  // as the register has it
  std::uint32_t agp = 0;       // 1: the card has an AGP capability

  constexpr void fields(auto&& list) { list(driver_bytes, config_hash, fidelity, agp); }
};

struct FrameHeader {
  FrameType type{};
  std::uint16_t flags = 0;  // FrameFlag
  std::uint32_t id = 0;     // chosen by the requester; the response carries it back
  std::uint32_t size = 0;   // of the payload; checked against the negotiated limit before memory is taken
  ErrorCode error = ErrorCode::kNone;
  std::uint32_t credit_slots = 0;  // frames that the sender has consumed since it last said so
  std::uint64_t time_ps = 0;       // requester: host clock when issued; board: simulated time of the event
  std::uint64_t credit_bytes = 0;  // payload bytes that the sender has consumed since it last said so
  std::uint32_t sequence = 0;      // counts the frames of one direction that take credit, from 1, modulo 2^32; else 0
  std::uint32_t checksum = 0;      // of header and payload (checksum.h)

  constexpr void fields(auto&& list) {
    list(std::uint32_t{kFrameMagic}, type, flags, id, size, error, credit_slots, time_ps, credit_bytes, sequence,
         checksum);
  }
  friend constexpr bool operator==(const FrameHeader&, const FrameHeader&) = default;
};
inline constexpr std::size_t kFrameHeaderBytes = bytes_of<FrameHeader>();

// Nothing if the magic or the type is wrong: what follows in the stream can't be trusted then.
inline std::optional<FrameHeader> decode_frame_header(std::span<const std::uint8_t, kFrameHeaderBytes> in) {
  const auto header = decode<FrameHeader>(in);
  const bool known = header.type >= FrameType::kVersion && header.type <= FrameType::kCheckpoint;
  if (load<std::uint32_t>(in, 0) != kFrameMagic || !known) return std::nullopt;
  return header;
}

// How far `sequence` is after `taken`: 1 = the next, more = frames are missing, 0 or less = a frame that was taken before.
constexpr std::int32_t sequence_step(std::uint32_t taken, std::uint32_t sequence) {
  return static_cast<std::int32_t>(sequence - taken);
}

inline constexpr std::uint16_t kMajorVersion = 2;
inline constexpr std::uint16_t kMinorVersion = 3;
inline constexpr std::uint16_t kCheckpointMinor = 3;         // kCheckpoint
inline constexpr std::uint16_t kColoursMinor = 3;            // VOXEL_FORMAT, IRRADIANCE_WORDS, the regions of colours
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

// Payload of kVersion (its bytes: README.md). Behind it a client's access token, if it has one (proto/gicube/access.h). Each side says what it speaks and how much it can take; the smaller minor version,
// payload limit and the common capabilities hold for the session.
struct VersionInfo {
  std::uint16_t major = kMajorVersion;
  std::uint16_t minor = kMinorVersion;
  std::uint32_t max_payload_bytes = 4u << 20;
  std::uint32_t window_slots = 64;  // the sender's own receive window
  std::uint64_t window_bytes = 16u << 20;
  std::uint64_t capabilities = 0;  // Capability
  std::uint32_t flags = 0;         // VersionFlag
  std::uint64_t session = 0;       // client: the session to resume, 0 = a new one; board: the session's token, never 0
  std::uint32_t taken = 0;         // last sequence number that was taken from the peer in this session; 0 in a new one
  std::uint32_t consumed = 0;      // last one whose credit the peer may use again, not later than `taken`
  std::uint32_t wait_ms = 0;       // client: how long it will wait for the board while that has an owner; board: 0

  constexpr void fields(auto&& list) {
    list(major, minor, max_payload_bytes, window_slots, flags, window_bytes, capabilities, session, taken, consumed,
         wait_ms, Reserved<4>{});
  }
  friend constexpr bool operator==(const VersionInfo&, const VersionInfo&) = default;
};
inline constexpr std::size_t kVersionBytes = bytes_of<VersionInfo>();

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
