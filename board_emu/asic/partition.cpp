#include "partition.h"

#include <algorithm>

namespace gicube::emu {

namespace {

unsigned owner(v1::Partition kind, unsigned processors, int slabs, const std::array<int, 3>& at) {
  switch (kind) {
    case v1::repeated_slab: return static_cast<unsigned>(at[0]) % processors;
    case v1::skewed_block: return static_cast<unsigned>(at[0] + at[1] + at[2]) % processors;
    default: return static_cast<unsigned>(at[0]) * processors / static_cast<unsigned>(slabs);
  }
}

}  // namespace

Partition::Partition(v1::Partition kind, unsigned processors, const std::array<int, 3>& blocks) : blocks_(processors) {
  const auto across = static_cast<std::size_t>(blocks[0]), down = static_cast<std::size_t>(blocks[1]);
  homes_.resize(across * down * static_cast<std::size_t>(blocks[2]));
  for (int x = 0; x < blocks[0]; ++x) {
    for (int y = 0; y < blocks[1]; ++y) {
      for (int z = 0; z < blocks[2]; ++z) {
        const std::size_t block =
            static_cast<std::size_t>(x) + across * (static_cast<std::size_t>(y) + down * static_cast<std::size_t>(z));
        const unsigned processor = owner(kind, processors, blocks[0], {x, y, z});
        homes_[block] = {static_cast<std::uint32_t>(blocks_[processor].size()), static_cast<std::uint8_t>(processor)};
        blocks_[processor].push_back(block);
      }
    }
  }
}

std::size_t Partition::max_blocks() const {
  std::size_t most = 0;
  for (const auto& blocks : blocks_) most = std::max(most, blocks.size());
  return most;
}

}  // namespace gicube::emu
