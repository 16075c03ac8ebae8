#include "player.h"

#include <fmt/format.h>

#include <algorithm>

#include "bus_client.h"
#include "capture_reader.h"
#include "gicube/wire/registers.h"

namespace gicube::replay {
namespace {

using wire::FrameType;

const char* name_of(FrameType type) {
  switch (type) {
    case FrameType::kConfigRead: return "config read";
    case FrameType::kConfigWrite: return "config write";
    case FrameType::kRegisterRead: return "register read";
    case FrameType::kMemoryRead: return "memory read";
    case FrameType::kCompletion: return "completion";
    case FrameType::kWait: return "wait";
    case FrameType::kPoll: return "poll";
    case FrameType::kCounters: return "counters";
    case FrameType::kCancel: return "cancel";
    default: return "frame";
  }
}

// Registers that say what board this is: another machine has others, and may.
bool is_identity(std::uint32_t offset) {
  const wire::RegisterInfo* info = wire::find_register(offset);
  const bool changes = offset == wire::reg::kStatus || offset == wire::reg::kErrorAddress;
  return info != nullptr && info->access == wire::Access::kReadOnly && !changes;
}

std::string payload_difference(const Answer& expected, const Answer& got) {
  if (expected.bytes != got.bytes) return fmt::format("{} bytes, not {}", got.bytes, expected.bytes);
  const std::size_t kept = std::min(expected.payload.size(), got.payload.size());
  for (std::size_t i = 0; i < kept; ++i) {
    if (expected.payload[i] != got.payload[i]) {
      return fmt::format("byte {} of {} is 0x{:02x}, not 0x{:02x}", i, got.bytes, got.payload[i], expected.payload[i]);
    }
  }
  return fmt::format("a byte behind the first {} of {}", kept, got.bytes);
}

class Comparison {
 public:
  Comparison(Recorded recorded, Report& report) : recorded_(std::move(recorded)), report_(report) {}

  void asked(const CapturedFrame& frame) {
    if (frame.header.type != FrameType::kRegisterRead || frame.payload.size() != 4) return;
    registers_[frame.header.id] = wire::load<std::uint32_t>(frame.payload, 0);
  }

  void take(const BusClient::Frame& frame) {
    const bool completes = frame.header.type == FrameType::kCompletion;
    auto& list = completes ? recorded_.completions : recorded_.responses;
    const auto found = list.find(frame.header.id);
    const Answer got = answer_of(frame.header, frame.payload);
    const std::string what = fmt::format("{} {} at {} ps", name_of(got.type), frame.header.id, got.time_ps);
    if (found == list.end()) return differ(what + ": was not there", values_);
    const Answer expected = std::move(found->second);
    list.erase(found);
    ++report_.compared;
    const auto question = registers_.find(frame.header.id);
    const bool identity = !completes && question != registers_.end() && is_identity(question->second);
    if (identity && question->second == wire::reg::kConfigHashLow) same_hash_low_ = expected.payload == got.payload;
    if (identity && question->second == wire::reg::kConfigHashHigh) same_hash_high_ = expected.payload == got.payload;
    const bool machines_own = identity || got.type == FrameType::kCounters || got.type == FrameType::kConfigRead;
    if (expected.error != got.error) {
      differ(fmt::format("{}: error {}, not {}", what, static_cast<unsigned>(got.error),
                         static_cast<unsigned>(expected.error)),
             values_);
    } else if (expected.bytes != got.bytes || expected.checksum != got.checksum) {
      differ(fmt::format("{}: {}", what, payload_difference(expected, got)), machines_own ? machine_ : values_);
    } else if (expected.time_ps != got.time_ps) {
      differ(fmt::format("{}: was at {} ps", what, expected.time_ps), machine_);
    }
  }

  void finish() {
    report_.missing = recorded_.completions.size() + recorded_.responses.size();
    report_.same_machine = same_hash_low_ && same_hash_high_;
    report_.differences = values_.count + (report_.same_machine ? machine_.count : 0);
    const bool machine_first =
        report_.same_machine && machine_.count > 0 && (values_.count == 0 || machine_.number < values_.number);
    report_.first_difference = machine_first ? machine_.first : values_.first;
  }

 private:
  struct Differences {
    std::uint64_t count = 0, number = 0;
    std::string first;
  };

  void differ(const std::string& text, Differences& where) {
    if (where.count++ > 0) return;
    where.first = text;
    where.number = report_.compared;
  }

  Recorded recorded_;
  Report& report_;
  std::unordered_map<std::uint32_t, std::uint32_t> registers_;  // request -> register
  Differences values_, machine_;  // of what every board must answer; of what only the same machine does
  bool same_hash_low_ = false, same_hash_high_ = false;  // of the configuration, if the host read it
};

}  // namespace

Report play(const std::filesystem::path& capture, Fd board, std::chrono::milliseconds watchdog) {
  Report report;
  Recorded recorded = read_recorded(capture);
  const std::uint32_t largest = recorded.largest_payload;
  Comparison comparison(std::move(recorded), report);
  BusClient client(std::move(board), largest, watchdog, [&](const BusClient::Frame& frame) { comparison.take(frame); });
  HostFrames frames(capture);
  CapturedFrame frame;
  while (frames.next(frame)) {
    comparison.asked(frame);
    client.send(frame.header, frame.payload);
    ++report.sent_frames;
    report.sent_bytes += frame.payload.size();
    if ((frame.header.flags & wire::kPosted) == 0) client.await_answer(frame.header.id);
  }
  report.complete = frames.complete();
  comparison.finish();
  return report;
}

}  // namespace gicube::replay
