// Frames of the data plane: the format of socket messages between driver and board. A frame has a header (README.md
// defines its bytes) and `size` bytes of payload.
//
// Frames are an envelope of the emulation, not bus traffic. The bus model only charges payloads
// (docs/reference/protocol.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr std::uint32_t kFrameMagic = 0x55434947;

enum class FrameType : std::uint16_t {
  kVersion = 1,        // first in both directions: VersionInfo
  kCredit = 2,         // posted; uses the header's credit fields, and id: the last sequence number that its sender used
  kConfigRead = 3,     // PCI configuration space: u32 offset -> u32 value
  kConfigWrite = 4,    // u32 offset, u32 value -> empty
  kRegisterRead = 5,   // BAR0: u32 offset -> u32 value; unmapped reads give all ones
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
  kCancel = 15,        // u32 ticket -> u32: 1 = the command had not started, it completes with kCancelled; otherwise 0
  kCheckpoint = 16,    // u32 CheckpointStep and its data; takes no simulated time, not counted by fault plans
};

enum FrameFlag : std::uint16_t {
  kResponse = 1 << 0,
  kPosted = 1 << 1,  // no response will follow
};

// These frames take no credit and have no sequence number. They are not sent again when a session is resumed.
constexpr bool is_free(FrameType type) {
  return type == FrameType::kVersion || type == FrameType::kCredit || type == FrameType::kProgress;
}

// The numbers are stable, because recorded traffic and applications' logs contain them.
enum class ErrorCode : std::uint32_t {
  kNone = 0,
  kProtocol = 1,     // malformed frame; the session is closed
  kVersion = 2,      // major versions differ; the session is closed
  kTooLarge = 3,     // a length beyond the negotiated limit; the session is closed
  kBusy = 4,         // the board has an owner; the session is closed
  kBadAddress = 5,   // no register or memory there
  kBadValue = 6,     // a field of a command or register is out of range
  kUnsupported = 7,  // not supported by this board or fidelity level
  kCancelled = 8,    // the board is shutting down
  kInternal = 9,     // an internal fault of the board
  kCorrupted = 10,   // wrong checksum or missing frame; the connection is closed, the session may be resumed
  kDeadline = 11,    // the deadline in device time passed first
  kMemory = 12,      // the RDRAM reported an error that it could not correct
  kTaken = 13,       // another client took the board by force; the session is closed
  kNoSession = 14,   // there is no such session to resume; the connection is closed
  kForbidden = 15,   // the token is missing, wrong or lacks the right; the connection is closed
};

// Steps of a kCheckpoint frame. A session has one checkpoint buffer, initially empty. docs/reference/protocol.md gives
// the order.
enum class CheckpointStep : std::uint32_t {
  kBegin = 1,  // empties the buffer -> empty
  kWrite = 2,  // bytes to append to the buffer -> empty
  kTake = 3,   // the data was the driver's part; the buffer becomes the board's checkpoint -> u64 its bytes
  kRead = 4,   // u64 offset, u64 length -> bytes of it
  kGoOn =
      5,  // restores the board from the checkpoint in the buffer or, if that is empty, from the one that its process
          // started with (gicube-board --restore) -> WentOn; the buffer then holds the driver's part
};

// Properties that may differ from those of the saved board.
struct WentOn {
  std::uint64_t driver_bytes = 0;  // 0: the checkpoint has no driver's part
  std::uint64_t config_hash = 0;
  std::uint32_t fidelity = 0;  // value of the register
  std::uint32_t agp = 0;       // 1: the card has an AGP capability

  constexpr void fields(auto&& list) { list(driver_bytes, config_hash, fidelity, agp); }
};

struct FrameHeader {
  FrameType type{};
  std::uint16_t flags = 0;  // FrameFlag
  std::uint32_t id = 0;     // chosen by the requester; the response carries it back
  std::uint32_t size = 0;   // size of the payload; checked against the negotiated limit before memory is allocated
  ErrorCode error = ErrorCode::kNone;
  std::uint32_t credit_slots = 0;  // frames that the sender has consumed since its last report
  std::uint64_t time_ps = 0;       // requester: host clock when issued; board: simulated time of the event
  std::uint64_t credit_bytes = 0;  // payload bytes that the sender has consumed since its last report
  std::uint32_t sequence = 0;      // counts the frames of one direction that take credit, from 1, modulo 2^32; else 0
  std::uint32_t checksum = 0;      // checksum of header and payload (checksum.h)

  constexpr void fields(auto&& list) {
    list(std::uint32_t{kFrameMagic}, type, flags, id, size, error, credit_slots, time_ps, credit_bytes, sequence,
         checksum);
  }
  friend constexpr bool operator==(const FrameHeader&, const FrameHeader&) = default;
};
inline constexpr std::size_t kFrameHeaderBytes = bytes_of<FrameHeader>();

// Returns nothing if the magic or the type is wrong. The rest of the stream is then not usable.
inline std::optional<FrameHeader> decode_frame_header(std::span<const std::uint8_t, kFrameHeaderBytes> in) {
  const auto header = decode<FrameHeader>(in);
  const bool known = header.type >= FrameType::kVersion && header.type <= FrameType::kCheckpoint;
  if (load<std::uint32_t>(in, 0) != kFrameMagic || !known) return std::nullopt;
  return header;
}

// Position of `sequence` relative to `taken`: 1 = the next frame, more = frames are missing, 0 or less = a repeated
// frame.
constexpr std::int32_t sequence_step(std::uint32_t taken, std::uint32_t sequence) {
  return static_cast<std::int32_t>(sequence - taken);
}

inline constexpr std::uint16_t kMajorVersion = 2;
inline constexpr std::uint16_t kMinorVersion = 3;
inline constexpr std::uint16_t kCheckpointMinor = 3;         // kCheckpoint
inline constexpr std::uint16_t kColoursMinor = 3;            // VOXEL_FORMAT, IRRADIANCE_WORDS, regions of colours
inline constexpr std::uint32_t kMaxHandshakePayload = 4096;  // limit before the version is agreed

enum Capability : std::uint64_t {
  kFunctionalLevel = 1 << 0,
  kApproximateLevel = 1 << 1,
  kCycleLevel = 1 << 2,
  kProgressFrames = 1 << 3,
  kHostRays = 1 << 4,
};

enum VersionFlag : std::uint32_t {
  kForce = 1 << 0,  // client: end the current owner's session and take the board
};

// Payload of kVersion (README.md defines its bytes). A client's access token follows, if it has one
// (proto/gicube/access.h). Each side states its version and limits. The smaller minor version, the smaller payload
// limit and the common capabilities apply to the session.
struct VersionInfo {
  std::uint16_t major = kMajorVersion;
  std::uint16_t minor = kMinorVersion;
  std::uint32_t max_payload_bytes = 4u << 20;
  std::uint32_t window_slots = 64;  // the sender's own receive window
  std::uint64_t window_bytes = 16u << 20;
  std::uint64_t capabilities = 0;  // Capability
  std::uint32_t flags = 0;         // VersionFlag
  std::uint64_t session = 0;       // client: the session to resume, 0 = a new one; board: the session's token, never 0
  std::uint32_t taken = 0;         // last sequence number taken from the peer in this session; 0 in a new one
  std::uint32_t consumed = 0;      // last sequence number whose credit was returned, not later than `taken`
  std::uint32_t wait_ms = 0;       // client: how long it waits for the board while that has another owner; board: 0

  constexpr void fields(auto&& list) {
    list(major, minor, max_payload_bytes, window_slots, flags, window_bytes, capabilities, session, taken, consumed,
         wait_ms, Reserved<4>{});
  }
  friend constexpr bool operator==(const VersionInfo&, const VersionInfo&) = default;
};
inline constexpr std::size_t kVersionBytes = bytes_of<VersionInfo>();

// Returns the agreed parameters after the handshake, or nothing if the major versions differ or a peer could never
// accept a frame. A window holds two frames of maximum size: credit is due at half a window, so unreturned credit never
// blocks a frame.
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
