// The map of the DSP's memory: first bytes of its regions.
#pragma once

#include <cstdint>

namespace gicube::emu::sdram_map {

inline constexpr std::uint64_t kMiB = 1 << 20;
inline constexpr std::uint64_t kOverflow = 0;        // overflowed rays, and trapped rays that were scattered
inline constexpr std::uint64_t kCode = 16 * kMiB;    // code of the DSP's loops
inline constexpr std::uint64_t kTables = 32 * kMiB;  // elements, pairs and lamps
inline constexpr std::uint64_t kBatch = 64 * kMiB;   // rays of the host, which are written back in place
inline constexpr std::uint64_t kTraps = 128 * kMiB;  // rays that wait for the host's routine
inline constexpr std::uint64_t kFramebuffer = 384 * kMiB;

inline constexpr std::uint64_t kRankBytes = 64 * kMiB;

}  // namespace gicube::emu::sdram_map
