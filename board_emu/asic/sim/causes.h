// The activity of a pipeline's resampling unit in a cycle, or the reason for its idleness. Every cycle has exactly one
// cause.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace gicube::emu {

enum class Cause : std::uint8_t {
  kBusy,        // a sample entered
  kLeap,        // a ray in an empty block took the cycle to skip it
  kSplat,       // the cache's banks were busy with a deposit, or its tiles or carriers could not leave
  kFill,        // the cache's banks were busy with an arrived packet, one of several that the next sample needs
  kMiss,        // the next sample's packets are under way: latency and transfer
  kBank,        // as kMiss, delayed by the memory's bank timing
  kRefresh,     // as kMiss, delayed by a refresh
  kLatency,     // all rays of this processor are in its pipeline
  kSorter,      // rays wait in queues, but the sorter has not delivered one; or it does not take one
  kQueueEmpty,  // the processor has no ray; other processors have them all
  kLink,        // a leaving ray waits for a neighbour link
  kRayBus,      // rays wait on the ray bus, or a finished ray for the merge tree
  kDsp,         // the processor has no ray; the DSP makes them too slowly
  kSdram,       // as kDsp, and the DSP waits for its memory
};

inline constexpr std::size_t kCauses = 14;
inline constexpr std::array<std::string_view, kCauses> kCauseNames{
    "busy",    "leap",   "splat",       "cache_fill", "cache_miss", "memory_bank", "refresh",
    "latency", "sorter", "queue_empty", "link",       "ray_bus",    "dsp_compute", "sdram"};

// Cause of a packet's delay beyond the occupancy of the data wires and the latency of its own commands.
enum class Delay : std::uint8_t {
  kTransfer,  // no delay, or the data wires: earlier packets, the turnaround
  kBank,      // its bank: other rows, other activations, precharges
  kRefresh,   // a refresh that kept its row closed, or one just before its activation
};

using CauseCounts = std::array<std::uint64_t, kCauses>;

}  // namespace gicube::emu
