// The threads of started calls, and the call that has its turn.
#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "operation.h"
#include "turns.h"

namespace gicube {

class StartedCalls {
 public:
  // Executes `work(progress)` in its turn, on a thread of its own. `now()`: the simulated host's clock. Throws
  // std::system_error if no thread can be started.
  template <class T>
  std::shared_ptr<OperationOf<T>> start(Turns& turns, std::function<T(const Progress&)> work,
                                        std::function<Picoseconds()> now) {
    auto call = std::make_shared<StartedCall<T>>();
    const std::lock_guard lock(mutex_);
    threads_.remove_if([](const Thread& each) { return each.ended->load(); });
    Thread& thread = threads_.emplace_back();
    const std::uint64_t place = turns.ask();
    ++under_way_;
    try {
      thread.thread =
          std::jthread([this, call, &turns, place, work = std::move(work), now = std::move(now), ended = thread.ended] {
            {
              const Turns::Turn turn = turns.await(place);
              thread_ = std::this_thread::get_id();
              current_ = call.get();
              call->run(work, now);
              current_ = nullptr;
              thread_ = std::thread::id();
              --under_way_;
            }
            *ended = true;
          });
    } catch (...) {
      --under_way_;
      threads_.pop_back();
      const Turns::Turn turn = turns.await(place);  // otherwise no later turn would come
      throw;
    }
    return call;
  }

  bool any() const { return under_way_ > 0; }
  // Whether this is the thread of the call that has its turn.
  bool is_here() const { return thread_.load() == std::this_thread::get_id(); }
  // Throws Cancelled if that call was cancelled.
  void check() const {
    if (const Cancellable* call = current_.load()) call->check();
  }
  // Waits until all calls have ended. The device must be closed.
  void end() {
    std::list<Thread> threads;
    {
      const std::lock_guard lock(mutex_);
      threads.swap(threads_);
    }
  }

 private:
  struct Thread {
    std::shared_ptr<std::atomic<bool>> ended = std::make_shared<std::atomic<bool>>(false);
    std::jthread thread{};
  };

  std::atomic<int> under_way_{0};
  std::atomic<std::thread::id> thread_{};
  std::atomic<Cancellable*> current_{nullptr};
  std::mutex mutex_;  // of the list
  std::list<Thread> threads_;
};

}  // namespace gicube
