// Ends the process on a signal within kMaxEnding, whatever its threads do.
//
// First in good order. What then still works, as a routine of others or a file system that does not answer, is broken off: a
// trace may lack its end.
#pragma once

#include <signal.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace gicube::emu {

// chosen: with what else has to be done, the process ends within a second.
inline constexpr std::chrono::milliseconds kMaxEnding{900};

class EndOnSignals {
 public:
  // Before any other thread begins: threads inherit who takes a signal. Until set_stop() a signal ends the process at once.
  explicit EndOnSignals(const std::vector<int>& signals);
  // In good order before kMaxEnding.
  ~EndOnSignals();

  EndOnSignals(const EndOnSignals&) = delete;
  EndOnSignals& operator=(const EndOnSignals&) = delete;

  // What the first signal calls, on a thread of its own. Replaces the former one.
  void set_stop(std::function<void()> stop);
  // A socket file that nobody else removes if the process is broken off.
  void add_file(const std::string& path);

 private:
  void watch();

  sigset_t signals_{};
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::function<void()> stop_;
  std::vector<std::string> files_;
  bool gone_ = false;
  std::thread thread_;  // last: it sees all of the others
};

}  // namespace gicube::emu
