// Maps a block to its processor and to its number there: the three partitions of Figure 1 [P §2.1] [H318, H331].
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

struct Home {
  std::uint32_t number = 0;  // of the block among its processor's blocks
  std::uint8_t processor = 0;
};

class Partition {
 public:
  // `blocks`: how many blocks the volume has along x, y, z. A processor numbers its blocks with x slowest and z
  // fastest: for simple slabs at the design point that is the paper's q = (x' << 6) + (y' << 3) + z' [P §3.2].
  Partition(const v1::AsicConfig& asic, const std::array<int, 3>& blocks) : blocks_(asic.processors()) {
    const v1::Partition kind = asic.partition();
    const unsigned processors = asic.processors();
    const auto across = static_cast<unsigned>(blocks[0]), down = static_cast<unsigned>(blocks[1]),
               deep = static_cast<unsigned>(blocks[2]);
    homes_.resize(std::size_t{across} * down * deep);
    for (unsigned x = 0; x < across; ++x) {
      for (unsigned y = 0; y < down; ++y) {
        for (unsigned z = 0; z < deep; ++z) {
          const std::size_t block = x + std::size_t{across} * (y + std::size_t{down} * z);
          const unsigned owner = kind == v1::repeated_slab ? x % processors
                                 : kind == v1::skewed_block
                                     ? (x * asic.skew_x() + y * asic.skew_y() + z * asic.skew_z()) % processors
                                     : x * processors / across;
          homes_[block] = {static_cast<std::uint32_t>(blocks_[owner].size()), static_cast<std::uint8_t>(owner)};
          blocks_[owner].push_back(block);
        }
      }
    }
  }

  const Home& home(std::size_t block) const { return homes_[block]; }
  // The block that has that number.
  std::size_t block(unsigned processor, std::uint32_t number) const { return blocks_[processor][number]; }
  std::size_t blocks() const { return homes_.size(); }
  std::size_t blocks_of(unsigned processor) const { return blocks_[processor].size(); }
  std::size_t max_blocks() const {  // the most that any processor owns
    return std::ranges::max(blocks_, {}, &std::vector<std::size_t>::size).size();
  }

 private:
  std::vector<Home> homes_;
  std::vector<std::vector<std::size_t>> blocks_;
};

}  // namespace gicube::emu
