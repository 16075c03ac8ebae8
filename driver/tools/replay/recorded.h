// What the board said in a captured session, to be held against what another one says.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <unordered_map>
#include <vector>

#include "capture_reader.h"

namespace gicube::replay {

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

// The frames of a host in their order, those that were sent again after a resume once, without what belongs to the
// connection alone (version, credit).
class HostFrames {
 public:
  explicit HostFrames(const std::filesystem::path& file) : reader_(file) {}
  bool next(CapturedFrame& frame);
  bool complete() const { return reader_.complete(); }

 private:
  CaptureReader reader_;
  std::uint32_t taken_ = 0;
};

struct Recorded {
  std::unordered_map<std::uint32_t, Answer> responses;    // by the request's id
  std::unordered_map<std::uint32_t, Answer> completions;  // by ticket
  std::optional<std::uint32_t> hash_low, hash_high;       // of the board's configuration, if the host read it
  std::uint32_t largest_payload = 0;                      // of all frames
};

// Reads the whole capture. Throws CaptureError.
Recorded read_recorded(const std::filesystem::path& file);

// The register that a request reads; nothing if it is no register read.
std::optional<std::uint32_t> register_read(const wire::FrameHeader& header, const std::vector<std::uint8_t>& payload);

}  // namespace gicube::replay
