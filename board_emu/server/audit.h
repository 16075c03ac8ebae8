// What people and programs did to this process's boards: who came, was refused, forced, configured, traced; one line each, and counts.
//
// Neither the file nor a flood of lines is without a bound: each kind of event has so many lines, and gets new ones with time, so that a flood
// of one kind hides no other. What is left out is counted.
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
  kRefused,     // a place in line, a board that has an owner, frames that are none
  kUnknown,     // no token, or a wrong one
  kForbidden,   // a token without the right
  kOpened,      // a board: a session begins
  kResumed,     // a session
  kForced,      // another session to end
  kClosed,      // a session has ended
  kConfigured,  // and what follows: by the management plane
  kReset,
  kTraced,
  kSaved,
  kFaultsSet,
  kDebugged,
  kLimitReached,  // of results, or of the time of a command
};

class Audit {
 public:
  struct Options {
    std::string file{};                     // empty: the lines go to the process's log
    std::size_t max_file_bytes = 8u << 20;  // chosen: with FILE.1, the former one, some hundred thousand lines
    unsigned burst = 100;                   // chosen: lines of a kind at once
    std::chrono::milliseconds refill{100};  // chosen: until there is one more
  };

  Audit();
  // Throws std::runtime_error: the file can't be written.
  explicit Audit(const Options& options);
  ~Audit();

  Audit(const Audit&) = delete;
  Audit& operator=(const Audit&) = delete;

  // Any thread. `who`: a peer; `what`: of which board, why. Both may have any bytes.
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
    unsigned lines = 0;       // that it still has
    Clock::time_point since;  // when it had them
  };
  bool takes_line(Kind& kind) const;

  const Options options_;
  std::shared_ptr<spdlog::logger> file_;  // null: the process's log
  mutable std::mutex mutex_;              // guards what follows
  std::array<Kind, kEvents> kinds_{};
};

}  // namespace gicube::emu
