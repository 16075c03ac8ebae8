// Reads a capture from front to back (docs/guide/capture.md), gzipped or not.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "gicube/wire/capture.h"
#include "gicube/wire/frame.h"

struct gzFile_s;  // zlib's; NOLINT(readability-identifier-naming)

namespace gicube::replay {

// The file is no capture, or damaged; the text names it and the byte.
struct CaptureError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct CapturedFrame {
  wire::CaptureRecord record;
  wire::FrameHeader header;
  std::vector<std::uint8_t> payload;
};

class CaptureReader {
 public:
  // Throws CaptureError.
  explicit CaptureReader(const std::filesystem::path& file);

  // The next numbered frame of one direction; what was sent again after a resume comes once. False at the end. Memory
  // is taken only as far as the file goes. Throws CaptureError: a record or frame that can't be, a wrong checksum.
  bool next(wire::CaptureKind direction, CapturedFrame& frame);
  // After the end: whether the capture was completed, or its process died before.
  bool complete() const { return complete_; }
  // Largest payload of all frames so far, in both directions.
  std::uint32_t largest_payload() const { return largest_payload_; }
  // That both sides spoke, as far as they have said so; ours if they have not.
  std::uint16_t minor_version() const { return minor_version_; }

 private:
  struct Close {
    void operator()(gzFile_s* file) const;
  };

  bool next_of_all(CapturedFrame& frame);
  std::size_t read(std::uint8_t* bytes, std::size_t count);
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path name_;
  std::unique_ptr<gzFile_s, Close> file_;
  std::uint64_t at_ = 0;  // byte, uncompressed
  bool complete_ = false;
  std::uint32_t largest_payload_ = 0;
  std::uint16_t minor_version_ = wire::kMinorVersion;
  std::array<std::uint32_t, 2> taken_{};  // by direction: the last number
};

// An answer without the weight of a large payload.
struct Answer {
  wire::FrameType type{};
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::uint64_t time_ps = 0;
  std::uint64_t bytes = 0;
  std::uint32_t checksum = 0;         // of the payload
  std::vector<std::uint8_t> payload;  // the first kKept bytes

  static constexpr std::size_t kKept = 4096;  // chosen
};

Answer answer_of(const wire::FrameHeader& header, const std::vector<std::uint8_t>& payload);

struct Recorded {
  std::unordered_map<std::uint32_t, Answer> responses;    // by the request's id
  std::unordered_map<std::uint32_t, Answer> completions;  // by ticket
  std::uint32_t largest_payload = 0;                      // of all frames
  std::uint16_t minor_version = wire::kMinorVersion;

  auto& answers(wire::FrameType type) { return type == wire::FrameType::kCompletion ? completions : responses; }
};

// Reads the whole capture. Throws CaptureError.
Recorded read_recorded(const std::filesystem::path& file);

}  // namespace gicube::replay
