// What a ray costs the DSP: a loop of its firmware, and what the loop needs of the SDRAM.
//
// The DSP is of the C62x class [C]: each cycle it begins up to eight instructions, of which two may multiply (16 by 16 bits) and
// two may load or store; loads and stores share six units with all other operations (TI, TMS320C6000 CPU and Instruction Set,
// SPRU189). A loop is software-pipelined: what bounds its interval is the unit that has most to do. Its row stands beside the
// function that computes its values.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "words/sdram_map.h"

namespace gicube::emu {

struct DspLoop {
  const char* name = "";
  std::uint32_t multiplies = 0;  // of an iteration
  std::uint32_t operations = 0;  // that are neither multiplications nor accesses
  std::uint32_t accesses = 0;    // loads and stores

  // Cycles from one iteration to the next.
  constexpr std::uint32_t interval() const {
    constexpr auto share = [](std::uint32_t work, std::uint32_t units) { return (work + units - 1) / units; };
    return std::max({share(multiplies, 2), share(accesses, 2), share(operations + accesses, 6),
                     share(multiplies + operations + accesses, 8)});
  }
  // Cycles to begin with it: a branch with its five delay slots, arguments, and its prologue, in which units are idle.
  constexpr std::uint32_t setup() const { return interval() == 0 ? 0 : kBranch + interval(); }
  // Of its code: an instruction has four bytes, and prologue and epilogue together are as long as the kernel.
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

  const DspLoop* loop = nullptr;  // null: there is nothing to do
  std::uint32_t more_cycles = 0;  // beside the iteration: a row's set-up, cut planes, a routine
  std::array<SdramUse, kMaxUses> uses{};
  std::uint8_t use_count = 0;

  DspTask& with(const SdramUse& use) {
    uses[use_count++] = use;
    return *this;
  }
  // Without what changing to its loop and waiting for the SDRAM costs.
  std::uint32_t cycles() const { return loop == nullptr ? 0 : loop->interval() + more_cycles; }
};

// Rays that are passed on as they are: 8 words read, 8 written, and 4 operations to find their place.
inline constexpr DspLoop kPassRay{"ray passed on", 0, 4, 16};
inline constexpr std::uint64_t kRayBytesInSdram = 32;

// Ray `i` of a batch of the host; a batch beyond the region's end is thought to begin anew.
constexpr SdramUse in_batch(std::uint64_t i, SdramUse::Kind kind) {
  constexpr std::uint64_t kPlaces = (sdram_map::kTraps - sdram_map::kBatch) / kRayBytesInSdram;
  return {sdram_map::kBatch + i % kPlaces * kRayBytesInSdram, kRayBytesInSdram, kind};
}

}  // namespace gicube::emu
