// Captures of a session's bus traffic (docs/guide/capture.md): a header, then records. Each record except the last is
// followed by the header and payload of its frame, as sent through the socket (frame.h). README.md defines the bytes.
#pragma once

#include <cstdint>

#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr std::uint64_t kCaptureMagic = 0x5450414355434947;
inline constexpr std::uint16_t kCaptureVersion = 1;

struct CaptureHeader {
  std::uint64_t magic = kCaptureMagic;
  std::uint16_t version = kCaptureVersion;

  constexpr void fields(auto&& list) { list(magic, version, Reserved<6>{}); }
};
inline constexpr std::size_t kCaptureHeaderBytes = bytes_of<CaptureHeader>();

// Host to board, board to host, end of the session.
enum class CaptureKind : std::uint64_t { kDown = 0, kUp = 1, kEnd = 2 };

struct CaptureRecord {
  CaptureKind kind = CaptureKind::kDown;
  std::uint64_t wall_ns = 0;  // wall clock since the capture began

  constexpr void fields(auto&& list) { list(kind, wall_ns); }
};
inline constexpr std::size_t kCaptureRecordBytes = bytes_of<CaptureRecord>();

}  // namespace gicube::wire
