// kLoadCoarse: a block of the volume's memory in fewer words than it has. README.md has its bytes.
//
// The words of (n / f)^3 cells follow, f = 2^level, packed as a block's (voxel.h), and behind them their colours if the card's voxels
// have some. The DSP writes each word to the f^3 voxels of its cell. Its completion is empty.
#pragma once

#include <cstdint>

#include "gicube/wire/command.h"
#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr int kMaxCoarseLevel = 3;

struct LoadCoarseHeader {
  std::uint32_t block = 0;  // of the volume
  std::uint8_t level = 0;   // 1..kMaxCoarseLevel, and 2^level at most half a block's edge

  constexpr void fields(auto&& list) { list(Opcode::kLoadCoarse, block, level, Reserved<3>{}); }
};
inline constexpr std::size_t kLoadCoarseHeaderBytes = bytes_of<LoadCoarseHeader>();

}  // namespace gicube::wire
