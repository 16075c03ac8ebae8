#include "end_on_signals.h"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <utility>

namespace gicube::emu {

EndOnSignals::EndOnSignals(const std::vector<int>& signals) {
  sigemptyset(&signals_);
  for (const int signal : signals) sigaddset(&signals_, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  thread_ = std::thread([this] { watch(); });
}

EndOnSignals::~EndOnSignals() {
  {
    const std::lock_guard lock(mutex_);
    gone_ = true;
  }
  changed_.notify_all();
  // Wakes the thread if it still waits for a signal. The signal is blocked, so it does not end the process.
  ::pthread_kill(thread_.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
  thread_.join();
}

void EndOnSignals::set_stop(std::function<void()> stop) {
  const std::lock_guard lock(mutex_);
  stop_ = std::move(stop);
}

void EndOnSignals::add_file(const std::string& path) {
  const std::lock_guard lock(mutex_);
  files_.push_back(path);
}

void EndOnSignals::watch() {
  int signal = 0;
  while (::sigwait(&signals_, &signal) != 0) continue;
  std::unique_lock lock(mutex_);
  if (gone_) return;
  if (stop_) {
    stop_();
    if (changed_.wait_for(lock, kMaxEnding, [this] { return gone_; })) return;
    spdlog::warn("work that had not ended after {} ms was aborted", kMaxEnding.count());
  }
  for (const std::string& file : files_) ::unlink(file.c_str());
  ::_exit(0);
}

}  // namespace gicube::emu
