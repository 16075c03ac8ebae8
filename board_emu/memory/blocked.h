// Base class of the memories: a volume in blocks of n^3 voxels, and the layout of a block with its +1 faces.
#pragma once

#include <array>
#include <cstddef>

namespace gicube::emu {

class Blocked {
 public:
  const std::array<int, 3>& size() const { return size_; }      // voxels
  const std::array<int, 3>& blocks() const { return blocks_; }  // along x, y, z
  int block_voxels() const { return n_; }

 protected:
  explicit Blocked(int block_voxels) : n_(block_voxels), edge_(static_cast<std::size_t>(block_voxels) + 1) {}

  // Returns the number of blocks of a volume of that size.
  std::size_t resize_blocks(const std::array<int, 3>& size) {
    size_ = size;
    std::size_t count = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      blocks_[axis] = (size[axis] + n_ - 1) / n_;
      count *= static_cast<std::size_t>(blocks_[axis]);
    }
    return count;
  }
  std::size_t voxels_of_block() const {
    const auto n = static_cast<std::size_t>(n_);
    return n * n * n;
  }
  std::size_t voxels_and_faces() const { return edge_ * edge_ * edge_; }

  std::array<int, 3> place(std::size_t block) const {
    const auto nx = static_cast<std::size_t>(blocks_[0]), ny = static_cast<std::size_t>(blocks_[1]);
    return {static_cast<int>(block % nx), static_cast<int>(block / nx % ny), static_cast<int>(block / (nx * ny))};
  }
  std::size_t block_at(int x, int y, int z) const {
    return static_cast<std::size_t>(x + blocks_[0] * (y + blocks_[1] * z));
  }
  // Index of a voxel in a block with faces.
  std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>(x) + edge_ * (static_cast<std::size_t>(y) + edge_ * static_cast<std::size_t>(z));
  }

  int n_;
  std::size_t edge_;  // n + 1
  std::array<int, 3> size_{};
  std::array<int, 3> blocks_{};
};

}  // namespace gicube::emu
