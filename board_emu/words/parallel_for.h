// Independent pieces of work on the host's threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace gicube::emu {

// The host's threads to use where `wanted` are asked for; 0: all.
inline unsigned thread_count(unsigned wanted) {
  return wanted != 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

// Runs `job(i, counters)` for i in [0, count) on `threads` threads and adds their counters up. What one of them throws
// ends all, and is thrown again.
template <typename Counters, typename Job>
Counters parallel_for(std::size_t count, unsigned threads, const Job& job) {
  std::atomic<std::size_t> next{0};
  std::vector<Counters> each(std::max(threads, 1u));
  std::mutex fault_mutex;
  std::exception_ptr fault;
  const auto work = [&](Counters& counters) {
    try {
      for (std::size_t i = next++; i < count; i = next++) job(i, counters);
    } catch (...) {
      next = count;
      const std::lock_guard lock(fault_mutex);
      if (!fault) fault = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < each.size() && t < count; ++t) others.emplace_back([&, t] { work(each[t]); });
    work(each[0]);
  }
  if (fault) std::rethrow_exception(fault);
  Counters sum;
  for (const Counters& counters : each) sum += counters;
  return sum;
}

}  // namespace gicube::emu
