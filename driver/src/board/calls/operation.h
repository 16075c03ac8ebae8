// Operations: the calls behind Pending handles.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "board/deadline.h"
#include "gicube/error.h"
#include "gicube/pending.h"
#include "transport/event.h"

namespace gicube {

class Operation {
 public:
  virtual ~Operation() = default;
  // The calls of PendingCall.
  virtual bool wait(std::chrono::milliseconds timeout) = 0;
  virtual bool cancel() = 0;
  virtual PendingProgress progress() const = 0;
  virtual Fd descriptor() = 0;
};

template <class T>
class OperationOf : public Operation {
 public:
  virtual T take(Picoseconds deadline) = 0;  // Pending::get()
};

// The flag by which a started call is cancelled.
class Cancellable {
 public:
  void cancel() { cancelled_ = true; }
  // Throws Cancelled.
  void check() const {
    if (cancelled_) throw Cancelled("the application has cancelled the call");
  }

 private:
  std::atomic<bool> cancelled_{false};
};

template <class T>
class StartedCall final : public OperationOf<T>, public Cancellable {
 public:
  bool wait(std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::min(timeout, kLongest), [this] { return ended_; });
  }
  bool cancel() override {
    const std::lock_guard lock(mutex_);
    if (!ended_) Cancellable::cancel();
    return !ended_;
  }
  PendingProgress progress() const override {
    const std::lock_guard lock(mutex_);
    return progress_;
  }
  Fd descriptor() override { return event_.descriptor(); }

  T take(Picoseconds deadline) override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ended_; });
    if (taken_) throw BadArgument("pending", "a result that was not taken yet", "one that get() has returned");
    if (completed_ > deadline && !error_) throw deadline_passed(deadline);
    taken_ = true;
    // The exception is not kept here: the call's thread could release it while the receiver still uses it.
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
    if constexpr (!std::is_void_v<T>) return std::move(*result_);
  }

  // Executes the call, on its thread. `now()`: the simulated host's clock.
  void run(const auto& work, const auto& now) {
    std::exception_ptr error;
    std::optional<Result> result;
    try {
      check();
      const Progress told = [this](std::uint32_t done, std::uint32_t all) {
        check();
        const std::lock_guard lock(mutex_);
        progress_ = {done, all};
      };
      if constexpr (std::is_void_v<T>) {
        work(told);
      } else {
        result = work(told);
      }
    } catch (...) {
      error = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      error_ = std::move(error);
      if (result) result_ = std::move(result);
      completed_ = now();
      ended_ = true;
    }
    changed_.notify_all();
    event_.happen();
  }

 private:
  using Result = std::conditional_t<std::is_void_v<T>, std::monostate, T>;
  static constexpr std::chrono::milliseconds kLongest = std::chrono::hours(24 * 365);  // can't overflow the clock

  mutable std::mutex mutex_;  // of all below but the event
  std::condition_variable changed_;
  bool ended_ = false;
  bool taken_ = false;
  PendingProgress progress_;
  Picoseconds completed_ = 0;
  std::optional<Result> result_;
  std::exception_ptr error_;
  Event event_;
};

}  // namespace gicube
