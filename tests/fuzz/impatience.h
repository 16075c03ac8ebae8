// Cancels work that takes too long: an input may well ask for hours. A board that does not hear it is a finding, by the
// fuzzer's own time limit. One thread for all inputs: to begin and end one with each would cost more than the board
// does.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "levels/level.h"

namespace gicube::fuzz {

class Impatience {
 public:
  static Impatience& instance() {
    static Impatience impatience;
    return impatience;
  }

  void begin(emu::Progress& work) {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    end_ = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
  }
  void end() {
    const std::lock_guard lock(mutex_);
    work_ = nullptr;
  }

 private:
  Impatience() : thread_([this] { watch(); }) {}
  ~Impatience() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  void watch() {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(50), [this] { return over_; })) {
      if (work_ != nullptr && std::chrono::steady_clock::now() > end_) work_->cancel = true;
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  emu::Progress* work_ = nullptr;
  std::chrono::steady_clock::time_point end_;
  bool over_ = false;
  std::thread thread_;  // last: it sees all of the others
};

}  // namespace gicube::fuzz
