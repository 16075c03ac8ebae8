// Loads a volume: converts samples to densities and gradient codes, cuts them into blocks and sends these to the board.
// Verifies the blocks on the board.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "encode/argument.h"
#include "encode/volume/gradients.h"
#include "encode/volume/planes.h"
#include "encode/volume/samples.h"
#include "gicube/wire/checksum.h"
#include "gicube/wire/command.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {

namespace reg = wire::reg;

namespace {

constexpr std::size_t kMinCapacity = 8;  // blocks: one, and its neighbours that hold the voxels on its +1 faces

}  // namespace

LoadedVolume& BoardState::whole(const char* what) {
  LoadedVolume& all = loaded(what);
  need_all_blocks(what);
  if (!bricks) return all;
  const std::size_t n = static_cast<std::size_t>(info.block_voxels);
  throw Unsupported(
      fmt::format("dims: {} expects a volume that the card stores whole, at most {} blocks of {}^3 voxels "
                  "(asic.max_volume_voxels), got {} x {} x {} voxels in {} blocks",
                  what, capacity_blocks(), n, all.dims[0], all.dims[1], all.dims[2], all.statistics.size()));
}

void BoardState::need_all_blocks(const char* what) const {
  if (shared)
    throw Unsupported(
        fmt::format("{} does not work on a board that shares its volume's blocks with other ranks", what));
}

void BoardState::need_no_routine_in_bricks(const char* what, bool lighting) {
  if (!bricks) return;
  for (const Material& material : tables.materials()) {
    const bool asks_host = material.bsdf == Bsdf::kTrap && material.routine == kHostRoutine;
    if (asks_host && (lighting || material.seen_through_scattering)) whole(what);
  }
}

void BoardState::need_colours_on_card(const char* what) {
  if (info.irradiance_words == 1) return;
  whole(what);
  for (std::size_t tag = 0; tag < tables.materials().size(); ++tag) {
    const Material& material = tables.materials()[tag];
    if (material.bsdf != Bsdf::kTrap || material.routine != kHostRoutine) continue;
    throw Unsupported(fmt::format(
        "{}: the material of tag {} is scattered by the application, whose rays have one energy. A board with three "
        "irradiance words (asic.irradiance_words) scatters light by its own routines",
        what, tag));
  }
}

void VolumeStore::load(const VolumeView& view, const Progress& progress) {
  const auto lock = state_->begin();
  check_volume(view, state_->max_edge());
  state_->check_colours(!view.colours.empty());
  state_->load(Planes(view), progress);
}

void VolumeStore::load(const VolumeStream& stream, const Progress& progress) {
  const auto lock = state_->begin();
  expect(stream.read != nullptr, "read", "a function", "null");
  Planes planes(stream);
  check_shape(planes.shape(), state_->max_edge());
  state_->check_colours(planes.have_colours());
  state_->load(std::move(planes), progress);
}

Pending<void> VolumeStore::start_load(const VolumeView& view) {
  return state_->start<void>(
      [state = state_, view](const Progress& progress) { VolumeStore(*state).load(view, progress); });
}

Pending<void> VolumeStore::start_load(const VolumeStream& stream) {
  return state_->start<void>(
      [state = state_, stream](const Progress& progress) { VolumeStore(*state).load(stream, progress); });
}

void BoardState::check_colours(bool given) const {
  expect(!given || info.voxel_format != VoxelFormat::kDensity, "colours",
         "none, since the card's voxels have none (asic.voxel_format is density)", "some");
}

int BoardState::max_edge() const {
  const bool in_bricks = info.protocol_minor >= wire::kBricksMinor && capacity_blocks() >= kMinCapacity;
  return in_bricks ? static_cast<int>(wire::kMaxVolumeEdge) : info.max_volume_voxels;
}

void BoardState::load(Planes planes, const Progress& progress) {
  const VolumeView& shape = planes.shape();
  const int n = info.block_voxels;
  LoadedVolume loaded;
  loaded.dims = shape.dims;
  loaded.range = resolve_range(planes);
  loaded.relative_spacing = relative_spacing(shape.spacing);
  loaded.min_spacing = std::min({shape.spacing.x, shape.spacing.y, shape.spacing.z});
  loaded.coloured = planes.have_colours();
  loaded.gradients = shape.find_gradients || !shape.gradients.empty();
  loaded.blocks = block_grid(shape.dims, n);
  const bool fits = voxel_count(loaded.blocks) <= capacity_blocks() && !shared;
  if (fits && !planes.are_read()) {
    forget_volume();
    begin_blocks(loaded);
    for_each_block(planes, loaded, watched(progress),
                   [this](std::size_t block, std::span<const std::uint8_t> bytes) { write_block(block, bytes); });
  } else if (fits) {
    // If the reader throws, the board must keep its volume: so everything is read first.
    const BlockStore store = keep_blocks(planes, loaded, watched(progress));
    forget_volume();
    begin_blocks(loaded);
    std::vector<std::uint8_t> bytes;
    for (std::size_t block = 0; block < store.count(); ++block) {
      if (!store.has(block)) continue;
      store.read(block, bytes);
      write_block(block, bytes);
    }
  } else {
    BlockStore store = keep_blocks(planes, loaded, watched(progress));
    forget_volume();
    const auto place = planes.are_read() ? BlockStore::Place::kFile : BlockStore::Place::kMemory;
    BrickLight light(voxel_count(loaded.blocks), n, max_irradiance(info), place);
    bricks = std::make_unique<Bricks>(loaded.blocks, n, std::move(store), std::move(light), capacity_blocks());
    begin_volume(loaded);
    if (shared) {
      std::vector<std::uint8_t> stored(bricks->count());
      for (std::size_t block = 0; block < stored.size(); ++block) stored[block] = bricks->has_voxels(block) ? 1 : 0;
      shared->begin(loaded.blocks, stored);
    }
    bricks->begin(device);
  }
  tables.send_segmentation(loaded.range);
  find_flags(loaded);
  check_fence();
  volume = std::move(loaded);
  if (!bricks && std::exchange(batches_wait, false)) send_batches_again();
}

void BoardState::forget_volume() {
  volume.reset();
  bricks.reset();
  kept_blocks.clear();
  blocks_are_kept = false;
  irradiance_unit = sum_unit = 0;  // the board clears them with the volume
  tables.forget_flags();
}

// Calls take(block, words) for each block that is not zero, in ascending order, and finds the statistics of all blocks.
// Works on one layer of blocks at a time, so that few planes are converted at once.
void BoardState::for_each_block(Planes& planes, LoadedVolume& of, const Progress& progress, const BlockTaker& take) {
  const std::size_t all = voxel_count(of.blocks);
  std::vector<std::uint8_t> bytes;
  for_each_layer(planes, info.block_voxels, of.range, tables.codebook(), threads, [&](const BlockLayer& layer) {
    for (std::size_t block = 0; block < layer.count; ++block) {
      of.statistics.push_back(layer.blocks.statistics(block));
      if (!layer.blocks.stored(block)) continue;
      if (progress) progress(static_cast<std::uint32_t>(layer.first + block), static_cast<std::uint32_t>(all));
      layer.blocks.pack(block, bytes);
      take(layer.first + block, bytes);
    }
  });
  if (progress) progress(static_cast<std::uint32_t>(all), static_cast<std::uint32_t>(all));
}

BlockStore BoardState::keep_blocks(Planes& planes, LoadedVolume& of, const Progress& progress) {
  BlockStore store(voxel_count(of.blocks), bytes_of_block(static_cast<std::size_t>(info.block_voxels), of.coloured),
                   planes.are_read() ? BlockStore::Place::kFile : BlockStore::Place::kMemory);
  for_each_block(planes, of, progress,
                 [&](std::size_t block, std::span<const std::uint8_t> bytes) { store.add(block, bytes); });
  return store;
}

void Board::share_blocks(std::shared_ptr<RayExchange> exchange) {
  const auto lock = state_->begin();
  expect(exchange != nullptr, "exchange", "a RayExchange", "null");
  expect(exchange->ranks() >= 1 && exchange->rank() >= 0 && exchange->rank() < exchange->ranks(), "exchange",
         "a rank of 0..ranks() - 1", fmt::format("{} of {}", exchange->rank(), exchange->ranks()));
  if (state_->volume) throw Rejected("share_blocks() must precede load_volume()");
  state_->device.need_minor(wire::kBricksMinor, "share_blocks() needs");
  if (state_->capacity_blocks() < kMinCapacity) {
    throw Unsupported(fmt::format("share_blocks() needs a board that stores {} blocks or more, this one stores {}",
                                  kMinCapacity, state_->capacity_blocks()));
  }
  state_->shared = std::make_unique<SharedBlocks>(std::move(exchange));
  state_->device.set_register(reg::kBricks, 1);
}

void BoardState::begin_volume(const LoadedVolume& of) {
  device.write_register(reg::kControl, wire::kControlClearVolume);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {  // even if it is the same: writing a size clears the volume
    device.write_register(reg::kVolumeX + 4 * axis, static_cast<std::uint32_t>(of.dims[axis]));
  }
  const wire::Spacing spacing = spacing_words(of.relative_spacing);
  for (std::uint32_t axis = 0; axis < 3; ++axis) device.set_register(reg::kSpacingX + 4 * axis, spacing[axis]);
  tables.send_gradients();
}

// Begins a volume that the card stores whole: all its blocks are zero on the board.
void BoardState::begin_blocks(const LoadedVolume& of) {
  begin_volume(of);
  blocks_are_kept = keep_volume;
  const std::size_t count = voxel_count(of.blocks);
  const std::vector<std::uint8_t> zeros(bytes_of_words(static_cast<std::size_t>(info.block_voxels)));
  block_sums.assign(count, wire::crc32c(zeros));
  colour_sums.clear();
  if (of.coloured) colour_sums.assign(count, 0);
}

// Waits until the board has processed all writes. Throws Rejected if it refused one.
void BoardState::check_fence() {
  constexpr std::uint32_t kFaults = wire::kStatusBadAddress | wire::kStatusBadValue | wire::kStatusNoMemory;
  const std::uint32_t faults = device.read_register(reg::kStatus) & kFaults;
  if (faults == 0) return;
  const std::uint32_t address = device.read_register(reg::kErrorAddress);
  device.write_register(reg::kStatusClear, faults);
  if ((faults & wire::kStatusNoMemory) != 0) {
    const std::uint32_t max = device.read_register(reg::kMaxMemory), asked = device.read_register(reg::kMemoryAsked);
    throw Rejected(fmt::format(
        "memory: expected at most {} MiB for volume, words and image (gicube-board --max-memory), got {} MiB", max,
        asked));
  }
  throw Rejected(fmt::format("the board refused a write: STATUS {}, ERROR_ADDRESS {}", faults, address));
}

std::vector<std::size_t> VolumeStore::verify() {
  const auto lock = state_->begin();
  state_->whole("verify_volume()");
  Device& device = state_->device;
  const std::vector<std::uint32_t>&sums = state_->block_sums, &colour_sums = state_->colour_sums;
  const std::size_t max_blocks = std::min<std::size_t>(wire::kMaxVerifyBlocks, device.agreed().max_payload_bytes / 4);
  std::vector<std::size_t> damaged;
  for (std::size_t first = 0; first < sums.size(); first += max_blocks) {
    const std::size_t count = std::min(max_blocks, sums.size() - first);
    const wire::VerifyCommand command{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(count)};
    const CommandResult result = device.run(wire::encoded(command), {});
    const std::size_t bytes = result.payload.size();
    if (bytes != 4 * count)
      device.give_up(fmt::format("the board returned {} bytes of checksums for {} blocks", bytes, count));
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t of_colours = colour_sums.empty() ? 0 : colour_sums[first + i];
      const auto found = wire::load<std::uint32_t>(result.payload, 4 * i);
      if (found != (sums[first + i] ^ of_colours)) damaged.push_back(first + i);
    }
  }
  return damaged;
}

}  // namespace gicube
