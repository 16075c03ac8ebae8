// Runs independent pieces of work on the host's threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace gicube {

// Returns `wanted`, or the number of hardware threads if `wanted` is 0.
inline unsigned thread_count(unsigned wanted) {
  return wanted != 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

// Runs `job(i)` for i in [0, count) on `threads` threads (0: all). If a job throws, no further jobs start and the first
// exception is rethrown.
template <typename Job>
void parallel_for(std::size_t count, unsigned threads, const Job& job) {
  std::atomic<std::size_t> next{0};
  std::mutex fault_mutex;
  std::exception_ptr fault;
  threads = thread_count(threads);
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) job(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(fault_mutex);
      if (!fault) fault = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < std::min<std::size_t>(threads, count); ++t) others.emplace_back(work);
    work();
  }
  if (fault) std::rethrow_exception(fault);
}

// Runs `job(begin, end)` for consecutive ranges of `run` numbers that cover [0, count).
template <typename Job>
void parallel_for_runs(std::size_t count, std::size_t run, unsigned threads, const Job& job) {
  parallel_for((count + run - 1) / run, threads, [&](std::size_t i) { job(i * run, std::min(count, (i + 1) * run)); });
}

// Runs `job(i, counters)` for i in [0, count). Returns the sum of all counters.
template <typename Counters, typename Job>
Counters parallel_sum(std::size_t count, unsigned threads, const Job& job) {
  std::mutex sum_mutex;
  Counters sum;
  parallel_for(count, threads, [&](std::size_t i) {
    Counters own;
    job(i, own);
    const std::lock_guard lock(sum_mutex);
    sum += own;
  });
  return sum;
}

}  // namespace gicube
