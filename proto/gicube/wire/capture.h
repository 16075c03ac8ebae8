// Captures of a session's bus traffic (docs/guide/capture.md): a file header, then records, each with the frame that it is about.
//
//   byte  size  file header
//      0     8  magic      "GICUCAPT"
//      8     2  version    1
//     10     6  reserved, 0
//
//   byte  size  record
//      0     1  kind       0 host to board, 1 board to host, 2 the session ended here: the last record, without a frame
//      1     7  reserved, 0
//      8     8  wall_ns    wall clock since the capture began, ns
//     16    48  the frame's header as it was on the socket (frame.h)
//     64     n  its payload
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

inline constexpr std::uint64_t kCaptureMagic = 0x5450414355434947;
inline constexpr std::uint16_t kCaptureVersion = 1;
inline constexpr std::size_t kCaptureHeaderBytes = 16;
inline constexpr std::size_t kCaptureRecordBytes = 16;

enum class CaptureKind : std::uint8_t { kDown = 0, kUp = 1, kEnd = 2 };

struct CaptureRecord {
  CaptureKind kind = CaptureKind::kDown;
  std::uint64_t wall_ns = 0;
};

inline void encode_capture_header(std::span<std::uint8_t, kCaptureHeaderBytes> out) {
  store(out, 0, kCaptureMagic);
  store(out, 8, std::uint64_t{kCaptureVersion});
}

// The version, or nothing if this is no capture.
inline std::optional<std::uint16_t> decode_capture_header(std::span<const std::uint8_t, kCaptureHeaderBytes> in) {
  if (load<std::uint64_t>(in, 0) != kCaptureMagic) return std::nullopt;
  return load<std::uint16_t>(in, 8);
}

inline void encode(const CaptureRecord& record, std::span<std::uint8_t, kCaptureRecordBytes> out) {
  store(out, 0, static_cast<std::uint64_t>(record.kind));
  store(out, 8, record.wall_ns);
}

// Nothing if no record can begin like that.
inline std::optional<CaptureRecord> decode_capture_record(std::span<const std::uint8_t, kCaptureRecordBytes> in) {
  const auto kind = load<std::uint64_t>(in, 0);
  if (kind > static_cast<std::uint64_t>(CaptureKind::kEnd)) return std::nullopt;
  return CaptureRecord{static_cast<CaptureKind>(kind), load<std::uint64_t>(in, 8)};
}

}  // namespace gicube::wire
