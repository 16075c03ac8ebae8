#include "gicube/board.h"

#include "encode/reflectance_map.h"
#include "encode/transfer_function_check.h"
#include "encode/volume/empty_flags.h"
#include "state.h"

namespace gicube {

std::unique_lock<std::mutex> Board::State::begin() {
  if (in_callback.load() == std::this_thread::get_id()) {
    throw Error("a callback may ask its Board for now() and info() only");
  }
  std::unique_lock lock(mutex);
  device.check();
  return lock;
}

Progress Board::State::watched(const Progress& progress) {
  if (!progress) return {};
  return [this, &progress](std::uint32_t done, std::uint32_t all) {
    const InCallback mark(*this);
    progress(done, all);
  };
}

LoadedVolume& Board::State::loaded(const char* what) {
  if (!volume) throw Rejected(std::string(what) + " needs a volume: call load_volume() first");
  return *volume;
}

void Board::State::find_flags(LoadedVolume& of) {
  of.flags = find_empty_blocks(of.statistics, tables.segmentation());
  tables.send_flags(of.flags);
}

ValueRange Board::value_range() const {
  const auto lock = state_->begin();
  return state_->loaded("value_range()").range;
}

void Board::set_transfer_function(const TransferFunction& function, int tag) {
  const auto lock = state_->begin();
  check(function, tag);
  state_->tables.set_function(function, tag);
  if (!state_->volume) return;
  state_->tables.send_segmentation(state_->volume->range);
  state_->find_flags(*state_->volume);
  state_->check_fence();
}

void Board::set_shading(const Shading& shading) {
  const auto lock = state_->begin();
  check(shading);
  state_->tables.set_shading(shading);
  if (!state_->volume) return;
  state_->tables.send_segmentation(state_->volume->range);  // ambient and knee stand there
  state_->check_fence();
}

void Board::set_gradient_codebook(std::span<const Vec3> codebook) {
  const auto lock = state_->begin();
  GradientCodebook checked(codebook);
  if (state_->volume) throw Rejected("set_gradient_codebook() comes before load_volume(): the voxels hold its codes");
  state_->tables.set_codebook(std::move(checked));
}

void Board::set_empty_flags(std::span<const std::uint8_t> flags) {
  const auto lock = state_->begin();
  LoadedVolume& volume = state_->loaded("set_empty_flags()");
  if (flags.size() != volume.statistics.size()) {
    throw BadArgument("flags", std::to_string(volume.statistics.size()) + " values, one a block",
                      std::to_string(flags.size()));
  }
  volume.flags.assign(flags.begin(), flags.end());
  for (std::uint8_t& flag : volume.flags) flag = flag != 0 ? 1 : 0;
  state_->tables.send_flags(volume.flags);
  state_->check_fence();
}

std::vector<std::uint8_t> Board::empty_flags() const {
  const auto lock = state_->begin();
  return state_->loaded("empty_flags()").flags;
}

Dims Board::blocks() const {
  const auto lock = state_->begin();
  return state_->loaded("blocks()").blocks;
}

Picoseconds Board::now() const { return state_->device.clock().now(); }

void Board::host_compute(Picoseconds duration) {
  const auto lock = state_->begin();
  state_->device.clock().work(duration);
}

Counters Board::counters() {
  const auto lock = state_->begin();
  return state_->device.counters();
}

}  // namespace gicube
