// Calls to a Board take turns, in the order in which they asked for them.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>

namespace gicube {

class Turns {
 public:
  // A turn that has come. It ends with this object.
  class Turn {
   public:
    Turn() = default;  // of a nested call: the outer one has the turn
    explicit Turn(Turns& of) : of_(&of) {}
    Turn(Turn&& other) noexcept : of_(std::exchange(other.of_, nullptr)) {}
    Turn& operator=(Turn&&) = delete;
    ~Turn() {
      if (of_ != nullptr) of_->end();
    }

   private:
    Turns* of_ = nullptr;
  };

  // Takes a place in the queue. await() must be called for it, once, on any thread.
  std::uint64_t ask() {
    const std::lock_guard lock(mutex_);
    return asked_++;
  }
  Turn await(std::uint64_t place) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return current_ == place; });
    return Turn(*this);
  }
  Turn take() { return await(ask()); }

 private:
  void end() {
    {
      const std::lock_guard lock(mutex_);
      ++current_;
    }
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t asked_ = 0;    // places taken
  std::uint64_t current_ = 0;  // the place that has its turn
};

}  // namespace gicube
