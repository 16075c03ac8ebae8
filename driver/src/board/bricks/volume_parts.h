// Deals a volume's blocks to ranks as boxes of equal cost, by recursive bisection with planes between blocks.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "encode/volume/samples.h"
#include "gicube/vector.h"

namespace gicube {

class VolumeParts {
 public:
  // `costs`: one per block, x fastest, not below 0. With more ranks than blocks some boxes are empty.
  VolumeParts(const Dims& blocks, std::span<const double> costs, int ranks);

  // Calls use(index) for each block of the rank's box.
  template <typename Use>
  void for_each_block(int rank, const Use& use) const {
    const Box& of = boxes_[static_cast<std::size_t>(rank)];
    for_each_position(of.low, of.high, [&](const Dims& at) { use(index_of(blocks_, at)); });
  }

 private:
  // Blocks with low <= number < high on each axis.
  struct Box {
    Dims low{}, high{};
  };

  void divide(const Box& box, std::span<const double> costs, int first, int ranks);

  Dims blocks_;
  std::vector<Box> boxes_;
};

}  // namespace gicube
