// Ends the process within kMaxEnding of a signal, whatever its threads do.
//
// It first tries an orderly shutdown. Work that is still running after that, such as a plug-in routine or a file system
// that does not respond, is aborted; a trace may then lack its end.
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

// chosen: including the remaining work, the process ends within a second.
inline constexpr std::chrono::milliseconds kMaxEnding{900};

class EndOnSignals {
 public:
  // Must be called before other threads start, because they inherit the signal mask. Until set_stop(), a signal ends
  // the process at once.
  explicit EndOnSignals(const std::vector<int>& signals);
  // Orderly end before kMaxEnding.
  ~EndOnSignals();

  EndOnSignals(const EndOnSignals&) = delete;
  EndOnSignals& operator=(const EndOnSignals&) = delete;

  // Sets the function that the first signal calls, on a separate thread. Replaces the previous one.
  void set_stop(std::function<void()> stop);
  // A file to remove if the process is aborted.
  void add_file(const std::string& path);

 private:
  void watch();

  sigset_t signals_{};
  std::mutex mutex_;  // guards the following
  std::condition_variable changed_;
  std::function<void()> stop_;
  std::vector<std::string> files_;
  bool gone_ = false;
  std::thread thread_;  // last, because it uses all members above
};

}  // namespace gicube::emu
