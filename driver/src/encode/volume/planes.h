// Planes of a volume, in the caller's memory or read in their order, and the blocks that they make up, a layer of
// blocks after the other: so that samples, densities and gradient codes of few planes are in memory at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "encode/volume/gradients.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/volume.h"

namespace gicube {

class Planes {
 public:
  explicit Planes(const VolumeView& view) : shape_(view) {}
  explicit Planes(const VolumeStream& stream);

  // The whole volume; of a stream without its samples.
  const VolumeView& shape() const { return shape_; }
  bool are_read() const { return read_ != nullptr; }
  bool have_colours() const { return read_colours_ != nullptr || !shape_.colours.empty(); }

  // Planes [first, first + count) as a volume of their own, which lasts until the next call. `first` and first + count
  // of a stream may not fall from call to call, but with first = 0 it is read from the start again. Of a stream each
  // new sample is checked: throws BadArgument that names it, and what the reader throws.
  VolumeView window(int first, int count);

 private:
  std::size_t bytes_of(int planes) const;
  std::size_t colour_bytes_of(int planes) const;

  VolumeView shape_;
  PlaneReader read_, read_colours_;
  std::vector<std::byte> held_, held_colours_;
  int first_ = 0, end_ = 0;  // planes in held_
};

// The volume's own range or the default that volume.h states: of a stream, by reading all of it.
ValueRange resolve_range(Planes& planes);

// A layer of blocks: those of `blocks` from 0 on are the volume's from `first` on, `count` of them; others it has are
// incomplete.
struct BlockLayer {
  const VoxelBlocks& blocks;
  std::size_t first, count;
};

// Calls take(layer) for all layers of blocks of n^3 voxels in their order. Values as of to_densities(),
// gradient_codes() and VoxelBlocks of the whole.
void for_each_layer(Planes& planes, int n, ValueRange range, const GradientCodebook& codebook, unsigned threads,
                    const std::function<void(const BlockLayer&)>& take);

}  // namespace gicube
