#include "player.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "capture_reader.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/reliable_window.h"
#include "transport/frame_stream.h"

namespace gicube::replay {
namespace {

using wire::FrameHeader;
using wire::FrameType;

struct Frame {
  FrameHeader header;
  std::vector<std::uint8_t> payload;
};

// By FrameType; frames that answer nothing have no name of their own.
constexpr std::array kNames{"frame", "frame",    "frame",       "config read", "config write", "register read",
                            "frame", "frame",    "memory read", "frame",       "completion",   "wait",
                            "poll",  "counters", "frame",       "cancel"};

// Registers that identify the board: other machines may have other values.
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
  return fmt::format("a byte after the first {} of {}", kept, got.bytes);
}

class Comparison {
 public:
  Comparison(Recorded recorded, Report& report) : recorded_(std::move(recorded)), report_(report) {}

  void asked(const CapturedFrame& frame) {
    if (frame.header.type != FrameType::kRegisterRead || frame.payload.size() != 4) return;
    registers_[frame.header.id] = wire::load<std::uint32_t>(frame.payload, 0);
  }

  void take(const Frame& frame) {
    auto& list = recorded_.answers(frame.header.type);
    const auto found = list.find(frame.header.id);
    const Answer got = answer_of(frame.header, frame.payload);
    const std::string what =
        fmt::format("{} {} at {} ps", kNames.at(static_cast<std::size_t>(got.type)), frame.header.id, got.time_ps);
    if (found == list.end()) return differ(what + ": is not in the capture", values_);
    const Answer expected = std::move(found->second);
    list.erase(found);
    ++report_.compared;
    const auto question = registers_.find(frame.header.id);
    const bool identity =
        got.type == FrameType::kRegisterRead && question != registers_.end() && is_identity(question->second);
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
  Differences values_, machine_;  // of answers that all boards must give; of those that only the same machine gives
  bool same_hash_low_ = false, same_hash_high_ = false;  // of the configuration, if the host read it
};

using BusError = std::runtime_error;  // the board refused the session, closed it, or does not answer

std::string text_of(const Frame& frame) { return {frame.payload.begin(), frame.payload.end()}; }

wire::VersionInfo version_for(std::uint32_t largest_payload, std::uint16_t minor_version) {
  wire::VersionInfo mine;
  mine.minor = minor_version;
  mine.max_payload_bytes = std::max(mine.max_payload_bytes, largest_payload);
  mine.window_bytes = std::max<std::uint64_t>(mine.window_bytes, 4 * std::uint64_t{mine.max_payload_bytes});
  mine.capabilities = wire::kFunctionalLevel | wire::kApproximateLevel | wire::kCycleLevel | wire::kHostRays;
  return mine;
}

// A minimal client of the bus: sends frames in their captured order, with their numbers. Throws BusError.
class BusClient : private FrameSink {
 public:
  // Takes a connected socket, shakes hands as `mine`. `comparison` receives all frames of the board except credit and
  // progress, within send() and await_answer().
  BusClient(Fd socket, const wire::VersionInfo& mine, std::chrono::milliseconds watchdog, const Access& access,
            Comparison& comparison)
      : watchdog_(watchdog),
        comparison_(comparison),
        mine_(mine),
        window_(mine_),
        stream_(std::move(socket), *this, {}, access.tls) {
    stream_.start();
    stream_.send(FrameHeader{FrameType::kVersion}, wire::version_payload(mine_, access.token), access.token.size());
    const Frame answer = receive();
    if (answer.header.type != FrameType::kVersion) throw BusError("no GI-Cube board answers there");
    if (answer.header.error != wire::ErrorCode::kNone) throw BusError(text_of(answer));
    if (answer.payload.size() < wire::kVersionBytes) throw BusError("the board's version is truncated");
    const auto theirs = wire::decode<wire::VersionInfo>(answer.payload);
    const auto agreed = wire::agree(mine_, theirs);
    if (!agreed) throw BusError(fmt::format("the board has protocol version {}.{}", theirs.major, theirs.minor));
    max_payload_ = agreed->max_payload_bytes;
    window_.open(theirs);
  }

  // Sets its credit and number; its id and time are those of the capture. Waits for credit.
  void send(const FrameHeader& header, const std::vector<std::uint8_t>& payload) {
    if (payload.size() > max_payload_) {
      throw BusError(fmt::format("a frame of {} bytes, the board takes {}", payload.size(), max_payload_));
    }
    while (!window_.can_send(payload.size())) take(receive());
    wire::ReliableWindow::Sent frame = window_.keep(header, wire::share(payload));
    window_.put_credit(frame.header);
    stream_.send(frame.header, std::move(frame.payload));
  }
  void await_answer(std::uint32_t id) {
    for (answered_ = 0; answered_ != id;) take(receive());
  }

 private:
  StreamFault check_header(const FrameHeader& header) override {
    if (header.size <= mine_.max_payload_bytes) return {};
    return {"the board sent something that is not a frame"};
  }
  StreamFault take_frame(const FrameHeader& header, std::vector<std::uint8_t> payload) override {
    const std::lock_guard lock(mutex_);
    arrived_.push_back({header, std::move(payload)});
    changed_.notify_all();
    return {};
  }
  void stream_ended(const StreamFault& reason) override {
    const std::lock_guard lock(mutex_);
    ended_ = reason.text;
    changed_.notify_all();
  }

  Frame receive() {
    std::unique_lock lock(mutex_);
    const auto has_news = [this] { return !arrived_.empty() || ended_; };
    if (watchdog_.count() == 0) {
      changed_.wait(lock, has_news);
    } else if (!changed_.wait_for(lock, watchdog_, has_news)) {
      throw BusError(fmt::format("no answer from the board within {} ms", watchdog_.count()));
    }
    if (arrived_.empty()) throw BusError(*ended_);
    Frame frame = std::move(arrived_.front());
    arrived_.pop_front();
    return frame;
  }
  void take(const Frame& frame) {
    const FrameHeader& header = frame.header;
    if (header.type == FrameType::kVersion) throw BusError("the board ended the session: " + text_of(frame));
    if (!window_.take_credit(header)) throw BusError("the board handed back credit that it never took");
    if (wire::is_free(header.type)) return;
    if (!window_.accept(frame.payload.size())) throw BusError("the board sent more than it had credit for");
    comparison_.take(frame);
    if ((header.flags & wire::kResponse) != 0) answered_ = header.id;
    window_.consume(frame.payload.size());
    if (window_.credit_is_due()) stream_.send(window_.credit_frame(wire::kPosted), wire::no_payload());
  }

  const std::chrono::milliseconds watchdog_;
  Comparison& comparison_;
  const wire::VersionInfo mine_;
  wire::ReliableWindow window_;
  std::uint32_t max_payload_ = 0;
  std::uint32_t answered_ = 0;  // the id of the last response

  std::mutex mutex_;  // guards what the stream's thread delivers
  std::condition_variable changed_;
  std::deque<Frame> arrived_;
  std::optional<std::string> ended_;

  FrameStream stream_;  // last: its thread ends before what it reports to
};

}  // namespace

Report play(const std::filesystem::path& capture, Fd board, std::chrono::milliseconds watchdog, const Access& access) {
  Report report;
  Recorded recorded = read_recorded(capture);
  const wire::VersionInfo mine = version_for(recorded.largest_payload, recorded.minor_version);
  Comparison comparison(std::move(recorded), report);
  BusClient client(std::move(board), mine, watchdog, access, comparison);
  CaptureReader frames(capture);
  CapturedFrame frame;
  while (frames.next(wire::CaptureKind::kDown, frame)) {
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
