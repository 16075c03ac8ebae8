// What a pipeline's resampling unit did in a cycle, or why it did nothing: every cycle has exactly one cause.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace gicube::emu {

enum class Cause : std::uint8_t {
  kBusy,        // a sample entered
  kLeap,        // a ray in an empty block took the cycle to leap
  kSplat,       // the cache's banks were busy with a deposit, or its tiles or carriers could not leave
  kFill,        // the cache's banks were busy with an arrived packet, one of several that the next sample needs
  kMiss,        // the next sample's packets are under way: latency and transfer
  kBank,        // the same, held up by the memory's bank timing
  kRefresh,     // the same, held up by a refresh
  kLatency,     // all rays of this processor are in its pipeline, on their way round
  kSorter,      // rays wait in queues, but the sorter has not delivered one; or it does not take one
  kQueueEmpty,  // no ray is here: the rays are with other processors
  kLink,        // a leaving ray waits for a neighbour link
  kRayBus,      // rays wait on the ray bus, or a finished ray for the merge tree
  kDsp,         // no ray is here: the DSP makes them more slowly
  kSdram,       // the same, and the DSP waits for its memory
};

inline constexpr std::size_t kCauses = 14;
inline constexpr std::array<std::string_view, kCauses> kCauseNames{
    "busy",    "leap",   "splat",       "cache_fill", "cache_miss", "memory_bank", "refresh",
    "latency", "sorter", "queue_empty", "link",       "ray_bus",    "dsp_compute", "sdram"};

// Why a packet of a memory came later than its channel's data wires and the latency of its own commands explain.
enum class Delay : std::uint8_t {
  kTransfer,  // it did not, or the data wires were taken: packets before it, the turnaround
  kBank,      // its bank: other rows, other activations, precharges
  kRefresh,   // a refresh that kept its row closed, or one just before its activation
};

using CauseCounts = std::array<std::uint64_t, kCauses>;

}  // namespace gicube::emu
