// Which blocks of a volume the rays of a picture come to, and in which order: front to back for any camera.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gicube/vector.h"
#include "gicube/view.h"
#include "gicube/wire/command.h"

namespace gicube {

// Blocks are numbered as in memory_map.h. A straight ray never comes back to a block column, row or layer that it has
// left, so on each axis it only goes away from the eye's block: the sum of the three distances, in blocks, is an order
// from front to back.
class BlockOrder {
 public:
  // `n`: the board's block edge, voxels. `blocks`: how many on each axis.
  BlockOrder(Dims blocks, int n, const wire::RenderCommand& camera, std::span<const CutPlane> cut_planes);

  // The blocks that rays may come to which wait for `waiting`, front to back, those themselves included. A ray whose
  // steps are longer than a block may come to others too.
  std::vector<std::size_t> reached_from(std::span<const wire::WaitingBlock> waiting) const;
  // Whether straight rays may come to it.
  bool sees(std::size_t block) const { return is_seen(place(block)); }

 private:
  // Where rays go on an axis through blocks of each index.
  struct Axis {
    std::vector<int> distance;  // blocks, from the eye's
    std::vector<int> before;    // the step to the index that they come from; 0: they come from this one
  };
  struct HalfSpace {  // of points p with normal . p >= offset, voxels
    Vec3 normal;
    double offset;
  };
  void add_pyramid(const wire::RenderCommand& camera);
  bool is_seen(const std::array<int, 3>& block) const;
  std::array<int, 3> place(std::size_t block) const;

  Dims blocks_;
  int n_;
  std::array<Axis, 3> axes_;
  std::vector<HalfSpace> seen_;
  std::vector<std::uint32_t> order_;  // all blocks
};

// Calls use(each) for the block and those above it on the axes, inside the volume, whose voxels are on its +1 faces:
// what the board must have so that samples in the block can be taken.
template <typename Use>
void for_each_sampled_in(std::size_t block, Dims blocks, const Use& use) {
  const auto nx = static_cast<std::size_t>(blocks[0]), ny = static_cast<std::size_t>(blocks[1]);
  const std::array<std::size_t, 3> at{block % nx, block / nx % ny, block / nx / ny}, stride{1, nx, nx * ny};
  for (unsigned above = 0; above < 8; ++above) {
    std::size_t other = block;
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((above >> axis & 1) == 0) continue;
      inside = inside && at[axis] + 1 < static_cast<std::size_t>(blocks[axis]);
      other += stride[axis];
    }
    if (inside) use(other);
  }
}
std::vector<std::size_t> blocks_sampled_in(std::size_t block, Dims blocks);

}  // namespace gicube
