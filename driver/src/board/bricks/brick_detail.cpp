// Level of detail of blocks: the coarseness that a picture allows for each, and the error that it causes.
#include <algorithm>

#include "board/state.h"
#include "encode/argument.h"
#include "encode/opacity_change.h"
#include "encode/volume/samples.h"
#include "gicube/level_of_detail.h"

namespace gicube {

std::vector<std::uint8_t> BoardState::levels_of(const View& view) const {
  std::vector<std::uint8_t> levels;
  if (detail <= 0 || view.scatter) return levels;
  const int n = bricks->block_voxels();
  int most = 0;  // largest cells: half a block
  while (most < wire::kMaxCoarseLevel && (4 << most) <= n) ++most;
  for_each_position({}, bricks->blocks(), [&](const Dims& block) {
    VoxelBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = n * block[axis];
      box.size[axis] = std::min(n, volume->dims[axis] - box.low[axis]);
    }
    const double voxels = voxels_a_pixel(view, box, volume->relative_spacing) * detail;
    levels.push_back(static_cast<std::uint8_t>(std::min(level_for(voxels), most)));
  });
  return levels;
}

void VolumeStore::set_detail(double detail) {
  const auto lock = state_->begin();
  expect(detail >= 0 && detail <= 64, "detail", "0..64", number_text(detail));
  if (detail > 0) state_->device.need_minor(wire::kBricksMinor, "set_brick_detail() needs");
  state_->detail = detail;
}

std::optional<BrickDetail> VolumeStore::detail() {
  const auto lock = state_->begin();
  const LoadedVolume& of = state_->loaded("brick_detail()");
  if (state_->framebuffer_size.first == 0) throw Rejected("brick_detail() needs a picture: call render() first");
  if (!state_->bricks) return std::nullopt;
  const Bricks::Detail detail = state_->bricks->detail();
  BrickDetail out{detail.blocks, static_cast<double>(detail.largest_error), 0};
  int low = wire::kDensityMax, high = 0;
  for (const BlockStatistics& block : of.statistics) {
    low = std::min<int>(low, block.min_density), high = std::max<int>(high, block.max_density);
  }
  out.largest_opacity = largest_opacity_change(state_->tables.functions(), of.range, low, high, detail.largest_error);
  return out;
}

}  // namespace gicube
