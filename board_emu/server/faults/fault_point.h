// Fault injection for a board's traffic: counts messages, decides the fault of each, keeps the log. Thread-safe.
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

// Fault of one message: a frame with a sequence number, when it is taken or sent for the first time.
struct FaultAction {
  std::chrono::microseconds pause{0};        // before everything else
  bool drop = false;                         // the message is lost
  bool twice = false;                        // the message arrives twice
  bool hang = false;                         // nothing passes until the connection ends
  bool cut = false;                          // the connection ends now, without an error message
  bool kill = false;                         // the process ends now, after all earlier messages have been written
  std::optional<std::uint32_t> flipped_bit;  // bit of the frame, header first, as on the wire
  std::optional<MemoryError> memory_error;   // to be added to the board before the message is executed

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

// A plan and its progress, as saved in a checkpoint. The log is not included.
struct SavedFaults {
  struct Slow {
    std::uint64_t bytes_per_second = 0;
    std::uint64_t messages = 0;  // remaining
    void state(Archive::Record& record) { record(bytes_per_second, messages); }
  };
  std::string plan_text{};  // empty: no plan
  FaultEngine::Counts counts{};
  std::array<Slow, 2> slow{};  // indexed by FaultEngine::lane()
  std::uint64_t faults = 0;    // number of faults so far

  void state(Archive& archive);
};

class FaultPoint {
 public:
  // The log keeps the first faults, because these suffice to repeat a run. A file keeps the first faults over all plans
  // of this process. chosen: a list that a person can read, and a message below a megabyte; a file of a tenth of a
  // gigabyte.
  static constexpr std::size_t kMaxLogged = 10'000, kMaxLines = 1'000'000;

  explicit FaultPoint(std::size_t max_logged = kMaxLogged, std::size_t max_lines = kMaxLines)
      : max_logged_(max_logged), max_lines_(max_lines) {}

  // Call when the next message of the host has arrived undamaged and in order. `frame_bytes` includes the header.
  FaultAction taken(std::size_t frame_bytes) { return next(v1::PlannedFault::down, frame_bytes); }
  FaultAction sent(std::size_t frame_bytes) { return next(v1::PlannedFault::up, frame_bytes); }

  // Replaces the plan and clears the log. An empty text is no plan. Returns the errors; nothing has changed then.
  std::vector<Diagnostic> set_plan(std::string_view text);

  SavedFaults saved() const {
    const std::lock_guard lock(mutex_);
    return {plan_text_, engine_.counts(), slow_, faults_};
  }
  // Continues a saved plan. Throws CheckpointFault; nothing has changed then.
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
    std::uint64_t left_out = 0;            // faults beyond max_logged_
  };
  // The first faults since the plan was set or the log was cleared.
  Log log(bool clear);

  // Also appends each fault to this file, as a line of plan text, before it takes effect. Throws std::runtime_error.
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
  std::array<SavedFaults::Slow, 2> slow_;  // indexed by FaultEngine::lane()
  std::uint64_t faults_ = 0;
  Log log_;                // in the order of occurrence
  std::size_t lines_ = 0;  // lines written by this process
  std::ofstream file_;     // log file, if open
  std::string file_name_;
};

}  // namespace gicube::emu
