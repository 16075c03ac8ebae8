// Where things lie in the DSP's memory, bytes.
#pragma once

#include <cstdint>

namespace gicube::emu::sdram_map {

inline constexpr std::uint64_t kMiB = 1 << 20;
inline constexpr std::uint64_t kOverflow = 0;        // overflowed rays, and trapped ones that were scattered
inline constexpr std::uint64_t kCode = 16 * kMiB;    // of loops
inline constexpr std::uint64_t kTables = 32 * kMiB;  // elements and pairs
inline constexpr std::uint64_t kBatch = 64 * kMiB;   // rays of the host, that go back into their places
inline constexpr std::uint64_t kTraps = 128 * kMiB;  // for rays that wait for the host's routine
inline constexpr std::uint64_t kFramebuffer = 384 * kMiB;

inline constexpr std::uint64_t kRankBytes = 64 * kMiB;

}  // namespace gicube::emu::sdram_map
