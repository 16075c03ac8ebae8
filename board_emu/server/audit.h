// Audit log of actions on this process's boards: connections, refusals, takeovers, changes, traces; one line per event,
// and counters.
//
// The file and the rate of lines are limited. Each kind of event has its own limit, so that a flood of one kind does
// not hide others. Omitted lines are counted.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace spdlog {
class logger;
}

namespace gicube::emu {

enum class AuditEvent {
  kConnected,
  kRefused,     // of a place in the queue, of a board that has an owner, of invalid frames
  kUnknown,     // a missing or wrong token
  kForbidden,   // a token that lacks the right
  kOpened,      // a session has begun
  kResumed,     // a session has been resumed
  kForced,      // another session was ended by force
  kClosed,      // a session has ended
  kConfigured,  // this and the following ones: by the management plane
  kReset,
  kTraced,
  kSaved,
  kFaultsSet,
  kDebugged,
  kLimitReached,  // for results, or for the time of a command
};

class Audit {
 public:
  struct Options {
    std::string file{};                     // empty: lines go to the process's log
    std::size_t max_file_bytes = 8u << 20;  // chosen: with FILE.1, the previous file, some hundred thousand lines
    unsigned burst = 100;                   // chosen: lines of one kind at once
    std::chrono::milliseconds refill{100};  // chosen: interval until one more line is allowed
  };

  Audit();
  // Throws std::runtime_error if the file cannot be written.
  explicit Audit(const Options& options);
  ~Audit();

  Audit(const Audit&) = delete;
  Audit& operator=(const Audit&) = delete;

  // Thread-safe. `who`: the peer. `what`: the board and the reason. Both may contain any bytes.
  void note(AuditEvent event, std::string_view who, std::string_view what);

  struct Count {
    const char* event;
    std::uint64_t count;
  };
  std::vector<Count> counts() const;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kEvents = static_cast<std::size_t>(AuditEvent::kLimitReached) + 1;

  struct Kind {
    std::uint64_t count = 0, left_out = 0;
    unsigned lines = 0;       // lines that are still allowed
    Clock::time_point since;  // time of the last refill
  };
  bool takes_line(Kind& kind) const;

  const Options options_;
  std::shared_ptr<spdlog::logger> file_;  // null: the process's log
  mutable std::mutex mutex_;              // guards kinds_
  std::array<Kind, kEvents> kinds_{};
};

}  // namespace gicube::emu
