// Which blocks a ray may leap over because nothing in them can be seen.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encode/volume/voxel_blocks.h"
#include "gicube/wire/lut.h"

namespace gicube {

// One value a block, 1 = no sample in it can be visible: for every tag that it holds, all entries between its least and
// its greatest density have opacity 0. `lut`: all 2^14 entries, index = tag << 12 | density. Never 1 for a block that
// shows something, whatever the interpolation; a block of density 0 and tag 0 (one that is not stored) counts as such.
// Throws BadArgument if the LUT has another size.
std::vector<std::uint8_t> find_empty_blocks(std::span<const BlockStatistics> blocks,
                                            std::span<const wire::SegmentationEntry> lut);
inline std::vector<std::uint8_t> find_empty_blocks(const VoxelBlocks& blocks,
                                                   std::span<const wire::SegmentationEntry> lut) {
  return find_empty_blocks(blocks.statistics(), lut);
}

// The bits of memory_map.h's empty_flags region: block b in bit b % 8 of byte b / 8; any nonzero flag is a one.
std::vector<std::uint8_t> pack_flags(std::span<const std::uint8_t> flags);

}  // namespace gicube
