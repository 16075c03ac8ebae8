// A volume's blocks, dealt to ranks as boxes that cost the same. The boxes come from halving the volume again and again, by planes
// between blocks, so that all rays of a picture come to the ranks in one order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "gicube/view.h"
#include "gicube/volume.h"
#include "gicube/wire/command.h"

namespace gicube {

// Blocks with low <= number < high on each axis.
struct BlockBox {
  std::array<int, 3> low{}, high{};
};

class VolumeParts {
 public:
  // `costs`: one a block, x fastest, not below 0. With more ranks than blocks some get an empty box. `upright`: the axis that is nearest to
  // the picture's vertical, if there is one. It is divided rather than others, since a low box is seen in few rows.
  VolumeParts(const Dims& blocks, std::span<const double> costs, int ranks, std::size_t upright = kNone);
  static constexpr std::size_t kNone = 3;

  const BlockBox& box(int rank) const { return boxes_[static_cast<std::size_t>(rank)]; }
  // Calls use(block's number) for each block of the rank's box.
  template <typename Use>
  void for_each_block(int rank, const Use& use) const {
    const BlockBox& of = box(rank);
    for (int z = of.low[2]; z < of.high[2]; ++z) {
      for (int y = of.low[1]; y < of.high[1]; ++y) {
        for (int x = of.low[0]; x < of.high[0]; ++x) use(number(x, y, z));
      }
    }
  }
  // The ranks as the view's rays come to their boxes; blocks of n^3 voxels.
  std::vector<int> front_to_back(const View& view, int n) const;
  // The rows of the picture in which the rank's box may be seen, of blocks of n^3 voxels: [first, second).
  std::pair<int, int> rows(int rank, const wire::RenderCommand& camera, int n) const;

 private:
  struct Node {
    std::size_t axis = 0;
    int plane = 0;               // blocks
    int rank = -1;               // of a leaf
    int below = -1, above = -1;  // else nodes
  };

  std::size_t number(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           blocks_[0] * (static_cast<std::size_t>(y) + blocks_[1] * static_cast<std::size_t>(z));
  }
  int divide(const BlockBox& box, std::span<const double> costs, int first, int ranks);

  std::array<std::size_t, 3> blocks_{};
  std::size_t upright_;
  std::vector<BlockBox> boxes_;
  std::vector<Node> nodes_;
};

}  // namespace gicube
