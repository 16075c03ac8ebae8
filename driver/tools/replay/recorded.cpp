#include "recorded.h"

#include <algorithm>

#include "gicube/wire/checksum.h"
#include "gicube/wire/registers.h"

namespace gicube::replay {

Answer answer_of(const wire::FrameHeader& header, const std::vector<std::uint8_t>& payload) {
  Answer answer{header.type, header.error, header.time_ps, payload.size(), wire::crc32c(payload), {}};
  const std::size_t kept = std::min(payload.size(), Answer::kKept);
  answer.payload.assign(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(kept));
  return answer;
}

bool HostFrames::next(CapturedFrame& frame) {
  while (reader_.next(frame)) {
    if (frame.record.kind != wire::CaptureKind::kDown || wire::is_free(frame.header.type)) continue;
    if (wire::sequence_step(taken_, frame.header.sequence) <= 0) continue;
    taken_ = frame.header.sequence;
    return true;
  }
  return false;
}

std::optional<std::uint32_t> register_read(const wire::FrameHeader& header, const std::vector<std::uint8_t>& payload) {
  if (header.type != wire::FrameType::kRegisterRead || payload.size() != 4) return std::nullopt;
  return wire::load<std::uint32_t>(payload, 0);
}

Recorded read_recorded(const std::filesystem::path& file) {
  Recorded recorded;
  CaptureReader reader(file);
  CapturedFrame frame;
  std::unordered_map<std::uint32_t, std::uint32_t> asked;  // request -> register
  std::uint32_t taken = 0;
  while (reader.next(frame)) {
    const wire::FrameHeader& header = frame.header;
    recorded.largest_payload = std::max(recorded.largest_payload, header.size);
    if (wire::is_free(header.type)) continue;
    if (frame.record.kind == wire::CaptureKind::kDown) {
      if (const auto offset = register_read(header, frame.payload)) asked[header.id] = *offset;
      continue;
    }
    if (wire::sequence_step(taken, header.sequence) <= 0) continue;
    taken = header.sequence;
    const bool completes = header.type == wire::FrameType::kCompletion;
    (completes ? recorded.completions : recorded.responses)
        .insert_or_assign(header.id, answer_of(header, frame.payload));
    const auto question = asked.find(header.id);
    if (completes || question == asked.end() || frame.payload.size() != 4) continue;
    const auto value = wire::load<std::uint32_t>(frame.payload, 0);
    if (question->second == wire::reg::kConfigHashLow) recorded.hash_low = value;
    if (question->second == wire::reg::kConfigHashHigh) recorded.hash_high = value;
  }
  return recorded;
}

}  // namespace gicube::replay
