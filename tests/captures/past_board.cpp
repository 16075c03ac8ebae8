#include "past_board.h"

#include <fmt/format.h>

#include "capture_reader.h"

namespace gicube::captures {

using reference::Frame;
using wire::FrameType;

namespace {

constexpr std::uint64_t kAllLevels = wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel;

}  // namespace

PastBoard::PastBoard(const std::filesystem::path& capture, std::uint16_t minor) : minor_(minor) {
  std::map<std::uint32_t, Frame> responses, completions;
  replay::CapturedFrame frame;
  for (replay::CaptureReader up(capture); up.next(wire::CaptureKind::kUp, frame);) {
    auto& list = frame.header.type == FrameType::kCompletion ? completions : responses;
    list.insert_or_assign(frame.header.id, Frame{frame.header, frame.payload});
  }
  for (replay::CaptureReader down(capture); down.next(wire::CaptureKind::kDown, frame);) {
    auto& list = frame.header.type == FrameType::kCommand ? completions : responses;
    const auto found = list.find(frame.header.id);
    if (found == list.end()) continue;
    found->second.header.credit_slots = 0;  // this session has its own
    found->second.header.credit_bytes = 0;
    answers_[{frame.header.type, frame.payload}].push_back(found->second);
  }
}

void PastBoard::serve(reference::FakeBoard& board) {
  wire::VersionInfo version;
  version.minor = minor_;
  version.capabilities = kAllLevels | wire::kHostRays;
  version.session = 1;
  board.shake_hands(version);
  while (const auto request = board.receive()) {
    const wire::FrameHeader& header = request->header;
    if (header.type == FrameType::kVersion) return;  // goodbye
    if (wire::is_free(header.type)) continue;
    board.return_credit(1, header.size);
    if (header.type == FrameType::kCommand) {
      under_way_.push_back(answer_to(*request));
      completed_[header.id] = under_way_.back().header.time_ps;
    } else if ((header.flags & wire::kPosted) == 0) {
      for (const Frame& completion : under_way_) board.send(completion.header, completion.payload);
      under_way_.clear();
      const Frame answer = answer_to(*request);
      board.send(answer.header, answer.payload);
    }
  }
}

Frame PastBoard::answer_to(const Frame& request) {
  const wire::FrameHeader& header = request.header;
  if (header.type == FrameType::kWait) {  // by the driver's own ticket
    wire::FrameHeader done{header.type, wire::kResponse, header.id};
    done.time_ps = completed_[wire::load<std::uint32_t>(request.payload, 0)];
    return {done, {}};
  }
  const auto found = answers_.find({header.type, request.payload});
  if (found != answers_.end()) {
    Frame answer = found->second.front();
    if (found->second.size() > 1) found->second.pop_front();
    answer.header.id = header.id;
    return answer;
  }
  const bool is_command = header.type == FrameType::kCommand;
  wire::FrameHeader refusal{header.type, wire::kResponse, header.id};
  if (header.type == FrameType::kRegisterRead) return {refusal, {0xFF, 0xFF, 0xFF, 0xFF}};  // one that it did not have
  if (is_command) refusal = {FrameType::kCompletion, wire::kPosted, header.id};
  refusal.error = wire::ErrorCode::kUnsupported;
  refused_.push_back(fmt::format("a frame of type {} with {} bytes", static_cast<int>(header.type), header.size));
  return {refusal, reference::bytes_of(refused_.back())};
}

}  // namespace gicube::captures
