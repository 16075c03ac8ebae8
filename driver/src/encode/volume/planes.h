// Processes a volume by planes, from the caller's memory or a reader, and cuts them into blocks, layer by layer: so
// that samples, densities and gradient codes of only a few planes are in memory at a time.
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

  // The whole volume; for a stream, without samples.
  const VolumeView& shape() const { return shape_; }
  bool are_read() const { return read_ != nullptr; }
  bool have_colours() const { return read_colours_ != nullptr || !shape_.colours.empty(); }

  // Planes [first, first + count) as a volume, valid until the next call. For a stream, `first` and first + count may
  // not decrease from call to call, except that first = 0 reads from the start again; new samples are checked: throws
  // BadArgument that names one, and what the reader throws.
  VolumeView window(int first, int count);

 private:
  std::size_t bytes_of(int planes) const;
  std::size_t colour_bytes_of(int planes) const;

  VolumeView shape_;
  PlaneReader read_, read_colours_;
  std::vector<std::byte> held_, held_colours_;
  int first_ = 0, end_ = 0;  // planes in held_
};

// The volume's range, or the default of volume.h; a stream may have to be read completely for it.
ValueRange resolve_range(Planes& planes);

// A layer of blocks: blocks 0 .. count - 1 of `blocks` are blocks first .. first + count - 1 of the volume. Further
// ones are incomplete.
struct BlockLayer {
  const VoxelBlocks& blocks;
  std::size_t first, count;
};

// Calls take(layer) for each layer of blocks of n^3 voxels, in order. Values are those of to_densities(),
// gradient_codes() and VoxelBlocks for the whole volume.
void for_each_layer(Planes& planes, int n, ValueRange range, const GradientCodebook& codebook, unsigned threads,
                    const std::function<void(const BlockLayer&)>& take);

}  // namespace gicube
