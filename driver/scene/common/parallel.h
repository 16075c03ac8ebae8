// Work that falls into parts that do not know of each other.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace gicube::scene {

inline int cores() { return static_cast<int>(std::max(1u, std::thread::hardware_concurrency())); }

// Runs job(i) for i in [0, count) on so many threads (0 = one a core). After an exception no further part is begun; the
// first one is thrown when all that ran have ended.
template <typename Job>
void in_parallel(std::size_t count, int threads, const Job& job) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) job(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::jthread> others;
  const std::size_t wanted = static_cast<std::size_t>(threads > 0 ? threads : cores());
  for (std::size_t t = 1; t < std::min(count, wanted); ++t) others.emplace_back(work);
  work();
  others.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace gicube::scene
