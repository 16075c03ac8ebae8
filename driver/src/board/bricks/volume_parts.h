// A volume's blocks, dealt to ranks as boxes that cost the same: the volume is halved again and again by planes between
// blocks.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "gicube/volume.h"

namespace gicube {

class VolumeParts {
 public:
  // `costs`: one a block, x fastest, not below 0. With more ranks than blocks some get an empty box.
  VolumeParts(const Dims& blocks, std::span<const double> costs, int ranks);

  // Calls use(block's number) for each block of the rank's box.
  template <typename Use>
  void for_each_block(int rank, const Use& use) const {
    const Box& of = boxes_[static_cast<std::size_t>(rank)];
    for (int z = of.low[2]; z < of.high[2]; ++z) {
      for (int y = of.low[1]; y < of.high[1]; ++y) {
        for (int x = of.low[0]; x < of.high[0]; ++x) use(number(x, y, z));
      }
    }
  }

 private:
  // Blocks with low <= number < high on each axis.
  struct Box {
    std::array<int, 3> low{}, high{};
  };

  std::size_t number(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           blocks_[0] * (static_cast<std::size_t>(y) + blocks_[1] * static_cast<std::size_t>(z));
  }
  void divide(const Box& box, std::span<const double> costs, int first, int ranks);

  std::array<std::size_t, 3> blocks_{};
  std::vector<Box> boxes_;
};

}  // namespace gicube
