#include "plan/levels.h"

#include <algorithm>

namespace gicube {
namespace {

constexpr double kWorthCropping = 0.9;  // chosen: share of the voxels; cropping must outweigh the copy
constexpr int kMinEdge = 8;             // chosen: voxels

double share_of(const VoxelBox& box, const Dims& dims) {
  double share = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) share *= double(box.size[axis]) / dims[axis];
  return share;
}

}  // namespace

void load_with_looks(Board& board, const VolumeView& volume, const Placement& placement,
                     std::span<const TransferFunction> looks) {
  board.load_volume(volume);
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < looks.size(); ++tag) {
    board.set_transfer_function(placement.look(looks[tag], range), static_cast<int>(tag));
  }
}

VolumeView without_unused(VolumeView volume, bool gradients) {
  volume.find_gradients = gradients;
  if (!gradients) volume.gradients = {};
  return volume;
}

Levels::Levels(Board& board, const VolumeView& volume, std::span<const TransferFunction> looks, bool gradients)
    : board_(board), looks_(looks), own_(!volume.samples.empty()), gradients_(gradients) {
  OneVolume& whole = volumes_[kWhole];
  whole.view = without_unused(volume, gradients);
  whole.dims = volume.dims;
  if (!own_) return;
  seen_ = visible_box(volume, looks);
  box_ = share_of(seen_, volume.dims) < kWorthCropping ? seen_ : VoxelBox{{}, volume.dims};
}

Levels::OneVolume Levels::derive(DerivedVolume volume, const Placement& outer) const {
  OneVolume out;
  out.derived = std::make_unique<DerivedVolume>(std::move(volume));
  out.view = without_unused(out.derived->view(), gradients_);
  const Placement& inner = out.derived->placement;
  out.placement = {outer.low + outer.edge * inner.low, outer.edge * inner.edge};
  out.dims = out.derived->dims;
  return out;
}

Levels::OneVolume& Levels::at(int level) {
  const OneVolume& whole = volumes_.at(kWhole);
  if (!own_ || level == kWhole || (level == 0 && box_.size == whole.dims)) return volumes_.at(kWhole);
  if (const auto found = volumes_.find(level); found != volumes_.end()) return found->second;
  if (level == 0) return volumes_[0] = derive(cropped(whole.view, box_), {});
  const OneVolume& fine = at(0);
  DerivedVolume coarse = coarser(fine.view, level);
  errors_.resize(std::max(errors_.size(), static_cast<std::size_t>(level)));
  errors_[static_cast<std::size_t>(level) - 1] = level_error(fine.view, coarse, looks_);
  return volumes_[level] = derive(std::move(coarse), fine.placement);
}

int Levels::max_level() const {
  if (!own_) return 0;
  const int shortest = *std::min_element(box_.size.begin(), box_.size.end());
  int level = 0;
  while (shortest >> (level + 1) >= kMinEdge) ++level;
  return level;
}

bool Levels::go_to(int level) {
  if (!own_) return false;
  OneVolume& wanted = at(level);
  const bool there = loaded_ && &at(*loaded_) == &wanted;
  loaded_ = level;
  if (!there) load_with_looks(board_, wanted.view, wanted.placement, looks_);
  return !there;
}

}  // namespace gicube
