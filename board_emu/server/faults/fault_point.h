// Where a board's fault plan meets its traffic: counts messages, says what becomes of each, keeps the log. Any thread.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "board/board.h"
#include "config/textproto_reader.h"
#include "fault_plan.h"

namespace gicube::emu {

// What becomes of one message: a frame with a sequence number, the first time that it is taken or sent.
struct FaultAction {
  std::chrono::microseconds pause{0};  // first of all
  bool drop = false;                   // as if it had been lost on its way
  bool twice = false;                  // it comes a second time
  bool hang = false;                   // neither it nor anything else passes until the connection ends
  bool cut = false;                    // the connection ends now, without a last word
  bool kill = false;                   // the process ends now, once all messages before this one have been written
  std::optional<std::uint32_t> flipped_bit;  // of the frame, header first, as it is on the wire
  std::optional<MemoryError> memory_error;   // to be given to the board before the message is carried out

  bool any() const {
    return pause.count() > 0 || drop || twice || hang || cut || kill || flipped_bit.has_value() ||
           memory_error.has_value();
  }
};

inline void flip_bit(std::size_t bit, std::span<std::uint8_t> header, std::span<std::uint8_t> payload) {
  const std::size_t at = bit / 8;
  std::uint8_t& byte = at < header.size() ? header[at] : payload[at - header.size()];
  byte = static_cast<std::uint8_t>(byte ^ (1u << bit % 8));
}

// A plan and how far it has come, as a checkpoint has it; the log is not in it.
struct SavedFaults {
  struct Slow {
    std::uint64_t bytes_per_second = 0;
    std::uint64_t messages = 0;  // still to come
    void state(Archive::Record& record) { record(bytes_per_second, messages); }
  };
  std::string plan_text{};  // empty: no plan
  FaultEngine::Counts counts{};
  std::array<Slow, 2> slow{};  // by FaultEngine::lane()
  std::uint64_t faults = 0;    // that have happened

  void state(Archive& archive);
};

class FaultPoint {
 public:
  // The log holds the first faults, since they make the same happen again; a file, the first of all plans of this process.
  // chosen: what a person can look through, and a message of less than a megabyte; a file of a tenth of a gigabyte.
  static constexpr std::size_t kMaxLogged = 10'000, kMaxLines = 1'000'000;

  explicit FaultPoint(std::size_t max_logged = kMaxLogged, std::size_t max_lines = kMaxLines)
      : max_logged_(max_logged), max_lines_(max_lines) {}

  // The host's next message has come undamaged and in order; `frame_bytes` with the header.
  FaultAction taken(std::size_t frame_bytes) { return next(v1::PlannedFault::down, frame_bytes); }
  FaultAction sent(std::size_t frame_bytes) { return next(v1::PlannedFault::up, frame_bytes); }

  // Replaces the plan and clears the log. An empty text is no plan. Returns what is wrong with it; then nothing changes.
  std::vector<Diagnostic> set_plan(std::string_view text);

  SavedFaults saved() const {
    const std::lock_guard lock(mutex_);
    return {plan_text_, engine_.counts(), slow_, faults_};
  }
  // Goes on where that plan was. Throws CheckpointFault: nothing has changed.
  void restore(const SavedFaults& saved);

  struct Info {
    std::string plan_text;
    std::uint64_t messages_down = 0;
    std::uint64_t messages_up = 0;
    std::uint64_t faults = 0;
  };
  Info info() const {
    const std::lock_guard lock(mutex_);
    return {plan_text_, engine_.message(v1::PlannedFault::down), engine_.message(v1::PlannedFault::up), faults_};
  }

  struct Log {
    std::vector<v1::PlannedFault> faults;  // down before up, then by message
    std::uint64_t left_out = 0;            // that came when there were max_logged
  };
  // The first faults that have happened since the plan was set or the log was cleared.
  Log log(bool clear);

  // Appends each fault to that file as well, as a line of plan text, before it takes effect. Throws std::runtime_error.
  void append_log_to(const std::string& path);

 private:
  FaultAction next(v1::PlannedFault::Direction direction, std::size_t frame_bytes);
  FaultAction act(const v1::PlannedFault& fault);

  void log_one(const v1::PlannedFault& fault);

  const std::size_t max_logged_, max_lines_;
  std::atomic<bool> has_plan_{false};
  mutable std::mutex mutex_;  // guards all below
  std::string plan_text_;
  FaultEngine engine_;
  std::array<SavedFaults::Slow, 2> slow_;  // by FaultEngine::lane()
  std::uint64_t faults_ = 0;
  Log log_;                // in the order of their happening
  std::size_t lines_ = 0;  // of the file, by this process
  std::ofstream file_;     // of the log, if it is open
  std::string file_name_;
};

}  // namespace gicube::emu
