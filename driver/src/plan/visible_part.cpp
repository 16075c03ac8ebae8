// What a camera and the transfer functions leave of a volume.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "gicube/level_of_detail.h"
#include "upload/density.h"
#include "upload/empty_flags.h"
#include "upload/segmentation_lut.h"
#include "upload/transfer_function_check.h"
#include "upload/volume_check.h"

namespace gicube {
namespace {

constexpr int kBlock = 4;  // chosen: finer than the board's blocks, and a fourteenth of a volume's voxels to look at

Vec3 times(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

std::vector<wire::SegmentationEntry> table_of(std::span<const TransferFunction> functions, ValueRange range) {
  std::vector<wire::SegmentationEntry> table;
  for (std::size_t tag = 0; tag < std::min<std::size_t>(functions.size(), wire::kTags); ++tag) {
    check(functions[tag], static_cast<int>(tag));
    const auto entries = segmentation_entries(functions[tag], range, {});
    table.insert(table.end(), entries.begin(), entries.end());
  }
  table.resize(wire::kSegmentationEntries);
  return table;
}

}  // namespace

VoxelBox visible_box(const VolumeView& volume, std::span<const TransferFunction> functions) {
  check_volume(volume, std::numeric_limits<int>::max());
  const ValueRange range = resolve_range(volume);
  const auto densities = to_densities(volume, range);
  const VoxelBlocks blocks(volume.dims, kBlock, densities, {}, volume.tags);
  const auto empty = find_empty_blocks(blocks, table_of(functions, range));
  const VoxelBox whole{{}, volume.dims};
  Dims low = volume.dims, high{-1, -1, -1};  // blocks
  for (std::size_t block = 0; block < empty.size(); ++block) {
    if (empty[block] != 0) continue;
    const auto nx = static_cast<std::size_t>(blocks.blocks()[0]), ny = static_cast<std::size_t>(blocks.blocks()[1]);
    const std::size_t at[] = {block % nx, block / nx % ny, block / nx / ny};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], static_cast<int>(at[axis]));
      high[axis] = std::max(high[axis], static_cast<int>(at[axis]));
    }
  }
  if (high[0] < 0) return whole;
  VoxelBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::max(0, low[axis] * kBlock - 1);
    const int last = std::min(volume.dims[axis] - 1, (high[axis] + 1) * kBlock + 1);
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
  constexpr int kMost = 6;  // as coarser()
  int level = 0;
  while (level < kMost && voxels_a_pixel >= 2 << level) ++level;
  return level;
}

}  // namespace gicube
