// kLoadCoarse: writes a block of the volume from fewer words than it has voxels. README.md defines the bytes.
//
// The header is followed by the words of (n / f)^3 cells, f = 2^level, packed like a block's (voxel.h), and by their
// colours if the card's voxels have colours. The DSP writes each word to the f^3 voxels of its cell. The completion is
// empty.
#pragma once

#include <cstdint>

#include "gicube/wire/command.h"
#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr int kMaxCoarseLevel = 3;

struct LoadCoarseHeader {
  std::uint32_t block = 0;  // number of the block in the volume
  std::uint8_t level = 0;   // 1..kMaxCoarseLevel; 2^level is at most half a block's edge

  constexpr void fields(auto&& list) { list(Opcode::kLoadCoarse, block, level, Reserved<3>{}); }
};
inline constexpr std::size_t kLoadCoarseHeaderBytes = bytes_of<LoadCoarseHeader>();

}  // namespace gicube::wire
