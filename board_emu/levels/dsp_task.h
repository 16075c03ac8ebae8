// The cost of a ray to the DSP: a loop of its firmware, and the loop's accesses to the SDRAM.
//
// The DSP is of the C62x class [C]: it issues up to eight instructions per cycle, including at most two multiplications
// (16 by 16 bits) and two loads or stores; loads and stores share six units with all other operations (TI, TMS320C6000
// CPU and Instruction Set, SPRU189). Loops are software-pipelined: the busiest unit bounds the interval. Each loop's
// DspLoop is defined next to the function that computes its values.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "words/sdram_map.h"

namespace gicube::emu {

struct DspLoop {
  const char* name = "";
  std::uint32_t multiplies = 0;  // per iteration
  std::uint32_t operations = 0;  // neither multiplications nor accesses
  std::uint32_t accesses = 0;    // loads and stores

  // Cycles between the starts of two iterations.
  constexpr std::uint32_t interval() const {
    constexpr auto share = [](std::uint32_t work, std::uint32_t units) { return (work + units - 1) / units; };
    return std::max({share(multiplies, 2), share(accesses, 2), share(operations + accesses, 6),
                     share(multiplies + operations + accesses, 8)});
  }
  // Cycles to start the loop: a branch with its five delay slots, arguments, and the prologue, in which units are idle.
  constexpr std::uint32_t setup() const { return interval() == 0 ? 0 : kBranch + interval(); }
  // Size of the loop's code: instructions have four bytes, and prologue and epilogue together are as long as the
  // kernel.
  constexpr std::uint32_t code_bytes() const { return 2 * 4 * (multiplies + operations + accesses); }

  static constexpr std::uint32_t kBranch = 6;
};

// Bytes of the SDRAM that an iteration reads, writes, or reads and writes.
struct SdramUse {
  enum class Kind : std::uint8_t { kRead, kWrite, kChange };

  std::uint64_t address = 0;
  std::uint32_t bytes = 0;
  Kind kind = Kind::kRead;
};

struct DspTask {
  static constexpr std::size_t kMaxUses = 4;

  const DspLoop* loop = nullptr;  // null: no work
  std::uint32_t more_cycles = 0;  // in addition to the iteration: set-up of a row, cut planes, a routine
  std::array<SdramUse, kMaxUses> uses{};
  std::uint8_t use_count = 0;

  DspTask& with(const SdramUse& use) {
    uses[use_count++] = use;
    return *this;
  }
  // Excludes the cycles for changing to the loop and for waiting for the SDRAM.
  std::uint32_t cycles() const { return loop == nullptr ? 0 : loop->interval() + more_cycles; }
};

// A ray that is passed on unchanged: 8 words read, 8 written, and 4 operations to compute addresses.
inline constexpr DspLoop kPassRay{"ray passed on", 0, 4, 16};
inline constexpr std::uint64_t kRayBytesInSdram = 32;

// Ray `i` of a batch of the host. Indices beyond the region's end wrap around.
constexpr SdramUse in_batch(std::uint64_t i, SdramUse::Kind kind) {
  constexpr std::uint64_t kPlaces = (sdram_map::kTraps - sdram_map::kBatch) / kRayBytesInSdram;
  return {sdram_map::kBatch + i % kPlaces * kRayBytesInSdram, kRayBytesInSdram, kind};
}

}  // namespace gicube::emu
