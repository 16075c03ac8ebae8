// Finds which blocks of a volume the rays of a picture can reach, and orders them front to back for any camera.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "encode/volume/samples.h"
#include "gicube/vector.h"
#include "gicube/view.h"
#include "gicube/wire/command.h"

namespace gicube {

// Blocks are numbered as in memory_map.h. On each axis a straight ray only moves away from the eye's block. So the sum
// of the three distances, in blocks, orders blocks from front to back.
class BlockOrder {
 public:
  // `n`: the board's block edge, voxels. `blocks`: their number on each axis.
  BlockOrder(Dims blocks, int n, const wire::RenderCommand& camera, std::span<const CutPlane> cut_planes);

  // The blocks that rays waiting for `waiting` can reach, front to back, including `waiting`. Rays whose steps are
  // longer than a block may reach others too.
  std::vector<std::size_t> reached_from(std::span<const wire::WaitingBlock> waiting) const;
  // Whether straight rays can reach the block.
  bool sees(std::size_t block) const { return is_seen(position_of(block, blocks_)); }

 private:
  // The direction of rays on one axis, by block index.
  struct Axis {
    std::vector<int> distance;  // from the eye's block, in blocks
    std::vector<int> before;    // step to the index that rays come from; 0: none
  };
  struct HalfSpace {  // of points p with normal . p >= offset, voxels
    Vec3 normal;
    double offset;
  };
  void add_pyramid(const wire::RenderCommand& camera);
  bool is_seen(const Dims& block) const;

  Dims blocks_;
  int n_;
  std::array<Axis, 3> axes_;
  std::vector<HalfSpace> seen_;
  std::vector<std::uint32_t> order_;  // all blocks
};

// Calls use(each) for the block and its upper neighbours inside the volume, which have the voxels on its +1 faces: the
// blocks that the board needs for samples in the block.
template <typename Use>
void for_each_sampled_in(std::size_t block, Dims blocks, const Use& use) {
  const auto nx = static_cast<std::size_t>(blocks[0]), ny = static_cast<std::size_t>(blocks[1]);
  const std::array<std::size_t, 3> stride{1, nx, nx * ny};
  const Dims at = position_of(block, blocks);
  for (unsigned above = 0; above < 8; ++above) {
    std::size_t other = block;
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((above >> axis & 1) == 0) continue;
      inside = inside && at[axis] + 1 < blocks[axis];
      other += stride[axis];
    }
    if (inside) use(other);
  }
}

}  // namespace gicube
