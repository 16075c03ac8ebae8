// An application that keeps tracing rays while everything that a fault plan can name goes wrong, and counts what came
// back.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace gicube::system_test {

struct SoakPlan {
  std::uint64_t seed = 1;
  std::size_t batches = 300;
  std::size_t rays = 100;          // in each batch
  std::size_t group = 8;           // batches under way together, between two looks at the volume
  std::uint32_t kills = 2;         // of the board's process; each starts a new one with a plan of its own
  std::uint64_t link_mean = 6;     // messages of a direction for each fault of the link
  std::uint64_t memory_mean = 80;  // down messages for each memory error
  std::uint32_t watchdog_ms = 200;
};

struct SoakReport {
  std::uint64_t rays = 0;     // accepted
  std::uint64_t lost = 0;     // never accepted
  std::uint64_t doubled = 0;  // accepted more than once
  std::uint64_t wrong = 0;    // other bits than on a sound board
  std::uint64_t faults = 0;
  std::map<std::string, std::uint64_t> kinds;
  std::uint64_t processes = 0;
  std::uint64_t memory_faults = 0;      // MemoryFault thrown
  std::uint64_t volumes_mended = 0;     // after silent errors
  std::uint64_t given_up = 0;           // times that the driver gave up resuming although the board lived
  std::uint64_t carried_out_twice = 0;  // rays that the last board counted beyond those that it returned
  std::uint64_t peak_memory = 0;        // the last board's, bytes
  std::string log;                      // of all processes, each sorted
};

// Throws what no fault of the plan explains.
SoakReport soak(const SoakPlan& plan);

}  // namespace gicube::system_test
