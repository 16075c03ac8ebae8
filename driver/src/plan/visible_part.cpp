// The visible part of a volume, and its level of detail in a picture.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "encode/look_up_tables.h"
#include "encode/vectors.h"
#include "encode/volume/samples.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/level_of_detail.h"

namespace gicube {
namespace {

constexpr int kBlock = 4;  // chosen: finer than the board's blocks, with little work per voxel

std::vector<wire::SegmentationEntry> table_of(std::span<const TransferFunction> functions, ValueRange range) {
  std::vector<wire::SegmentationEntry> table;
  for (std::size_t tag = 0; tag < std::min<std::size_t>(functions.size(), wire::kTags); ++tag) {
    check(functions[tag], static_cast<int>(tag));
    const auto entries =
        segmentation_entries(functions[tag], range, {}, true);  // as on the wide datapath, which shows most
    table.insert(table.end(), entries.begin(), entries.end());
  }
  table.resize(wire::kSegmentationEntries);
  return table;
}

// The minimum, the maximum and the tags of each position along x, over several rows of the volume. Densities increase
// with values, so only a block's extremes are converted.
template <typename Source>
class Row {
 public:
  using Value = typename Source::Value;
  Row(const Source& source, const VolumeView& volume)
      : source_(source),
        volume_(volume),
        size_(static_cast<std::size_t>(volume.dims[0])),
        min_(size_),
        max_(size_),
        tags_(volume.tags.empty() ? 0 : size_) {}

  // Replaces them by those of the rows from (y, z) to before (end_y, end_z).
  void gather(int y, int end_y, int z, int end_z) {
    std::fill(min_.begin(), min_.end(), std::numeric_limits<Value>::max());
    std::fill(max_.begin(), max_.end(), std::numeric_limits<Value>::lowest());
    std::fill(tags_.begin(), tags_.end(), std::uint8_t{0});
    for (int at_z = z; at_z < end_z; ++at_z) {
      for (int at_y = y; at_y < end_y; ++at_y) add(at_y, at_z);
    }
  }

  // The statistics of the voxels from x to before end.
  BlockStatistics statistics(std::size_t x, std::size_t end, ValueRange range) const {
    Value low = min_[x], high = max_[x];
    std::uint8_t tags = tags_.empty() ? 1 : 0;
    for (std::size_t i = x; i < end; ++i) {
      low = std::min(low, min_[i]);
      high = std::max(high, max_[i]);
      if (!tags_.empty()) tags |= tags_[i];
    }
    return {to_density(static_cast<double>(low), range), to_density(static_cast<double>(high), range), tags};
  }

 private:
  void add(int y, int z) {
    const std::size_t from = index_of(volume_.dims, 0, y, z);
    Value* const low = min_.data();
    Value* const high = max_.data();
    for (std::size_t x = 0; x < size_; ++x) {
      const Value value = source_[from + x];
      low[x] = std::min(low[x], value);
      high[x] = std::max(high[x], value);
    }
    for (std::size_t x = 0; x < tags_.size(); ++x) {
      tags_[x] = static_cast<std::uint8_t>(tags_[x] | 1u << volume_.tags[from + x]);
    }
  }

  const Source source_;
  const VolumeView& volume_;
  const std::size_t size_;
  std::vector<Value> min_, max_;
  std::vector<std::uint8_t> tags_;  // bit t: tag t
};

// A box of blocks; nothing is visible if high < low.
struct BlockRange {
  Dims low, high{-1, -1, -1};

  void add(const Dims& block) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], block[axis]);
      high[axis] = std::max(high[axis], block[axis]);
    }
  }
};

// The blocks with visible samples, also between their voxels and those of their upper neighbours.
BlockRange visible_blocks(const auto& source, const VolumeView& volume, ValueRange range,
                          std::span<const wire::SegmentationEntry> table) {
  BlockRange out{volume.dims};
  Row row(source, volume);
  std::vector<BlockStatistics> statistics;
  const auto end = [&volume](int block, std::size_t axis) {
    return std::min((block + 1) * kBlock + 1, volume.dims[axis]);
  };
  const Dims blocks{(volume.dims[0] + kBlock - 1) / kBlock, (volume.dims[1] + kBlock - 1) / kBlock,
                    (volume.dims[2] + kBlock - 1) / kBlock};
  for (int z = 0; z < blocks[2]; ++z) {
    statistics.clear();
    for (int y = 0; y < blocks[1]; ++y) {
      row.gather(y * kBlock, end(y, 1), z * kBlock, end(z, 2));
      for (int x = 0; x < blocks[0]; ++x) {
        statistics.push_back(
            row.statistics(static_cast<std::size_t>(x * kBlock), static_cast<std::size_t>(end(x, 0)), range));
      }
    }
    const auto empty = find_empty_blocks(statistics, table);
    for (std::size_t i = 0; i < empty.size(); ++i) {
      const int at = static_cast<int>(i);
      if (empty[i] == 0) out.add({at % blocks[0], at / blocks[0], z});
    }
  }
  return out;
}

}  // namespace

VoxelBox visible_box(const VolumeView& volume, std::span<const TransferFunction> functions) {
  check_volume(volume, std::numeric_limits<int>::max());
  const ValueRange range = resolve_range(volume);
  const auto table = table_of(functions, range);
  const BlockRange blocks =
      with_samples(volume, [&](auto source) { return visible_blocks(source, volume, range, table); });
  if (blocks.high[0] < 0) return {{}, volume.dims};
  VoxelBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::max(0, blocks.low[axis] * kBlock - 1);
    const int last = std::min(volume.dims[axis] - 1, (blocks.high[axis] + 1) * kBlock + 1);
    box.size[axis] = last - box.low[axis] + 1;
  }
  return box;
}

double voxels_a_pixel(const View& view, const VoxelBox& box, Vec3 spacing) {
  const Vec3 scale = relative_spacing(spacing);
  if (view.orthographic_height > 0) return view.orthographic_height / view.height;
  const Vec3 forward = normalise(times(scale, view.look_at - view.eye));
  double nearest = std::numeric_limits<double>::infinity();
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto at = [&](unsigned axis) {
      return static_cast<double>(box.low[axis] + ((corner >> axis & 1) != 0 ? box.size[axis] - 1 : 0));
    };
    nearest = std::min(nearest, dot(forward, times(scale, Vec3{at(0), at(1), at(2)} - view.eye)));
  }
  return std::max(0.0, nearest) * 2 * std::tan(view.fov_degrees * std::numbers::pi / 360) / view.height;
}

int level_for(double voxels_a_pixel) {
  constexpr int kMax = 6;  // as coarser()
  int level = 0;
  while (level < kMax && voxels_a_pixel >= 2 << level) ++level;
  return level;
}

}  // namespace gicube
