// Boxes of the volume and of its irradiance, read back and written, in whole planes of the board's blocks.
#include <algorithm>
#include <cmath>

#include "encode/argument.h"
#include "encode/volume/density.h"
#include "encode/volume/gradients.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};

void check(const VoxelBox& box, Dims dims) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("box.low.") + kAxisNames[axis];
    expect_within(name, box.low[axis], 0, dims[axis] - 1);
    expect_within(std::string("box.size.") + kAxisNames[axis], box.size[axis], 1, dims[axis] - box.low[axis]);
  }
}

std::size_t count(const VoxelBox& box) {
  return static_cast<std::size_t>(box.size[0]) * static_cast<std::size_t>(box.size[1]) *
         static_cast<std::size_t>(box.size[2]);
}

void check_values(const VoxelBox& box, std::span<const float> values, double min_value) {
  if (values.size() != count(box)) {
    throw BadArgument("values", std::to_string(count(box)) + ", one a voxel of the box", std::to_string(values.size()));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && values[i] >= min_value) continue;
    throw BadArgument("values[" + std::to_string(i) + "]",
                      std::isfinite(min_value) ? "a finite number of at least 0" : "a finite number",
                      number_text(static_cast<double>(values[i])));
  }
}

// The box with `more` voxels on every side, inside the volume.
VoxelBox grown(const VoxelBox& box, int more, Dims dims) {
  VoxelBox out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.low[axis] = std::max(0, box.low[axis] - more);
    out.size[axis] = std::min(dims[axis], box.low[axis] + box.size[axis] + more) - out.low[axis];
  }
  return out;
}

// The part of a box that lies in one block, whole rows and planes of which lie together in the board's memory.
struct BlockPart {
  std::size_t block = 0;
  Dims low{};             // the block's least voxel
  Dims begin{}, end{};    // of the part, voxels of the volume
  std::size_t first = 0;  // of the block's words, in planes from begin[2] on
  std::size_t words = 0;
};

// Which blocks hold the box.
template <typename Take>
void for_each_block(const VoxelBox& box, Dims blocks, int n, const Take& take) {
  Dims at{};
  const auto block_of = [n](int voxel) { return voxel / n; };
  const auto last = [&](std::size_t axis) { return block_of(box.low[axis] + box.size[axis] - 1); };
  for (at[2] = block_of(box.low[2]); at[2] <= last(2); ++at[2]) {
    for (at[1] = block_of(box.low[1]); at[1] <= last(1); ++at[1]) {
      for (at[0] = block_of(box.low[0]); at[0] <= last(0); ++at[0]) {
        BlockPart part;
        part.block = static_cast<std::size_t>(at[0] + blocks[0] * (at[1] + blocks[1] * at[2]));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          part.low[axis] = at[axis] * n;
          part.begin[axis] = std::max(box.low[axis], part.low[axis]);
          part.end[axis] = std::min(box.low[axis] + box.size[axis], part.low[axis] + n);
        }
        const auto plane = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
        part.first = static_cast<std::size_t>(part.begin[2] - part.low[2]) * plane;
        part.words = static_cast<std::size_t>(part.end[2] - part.begin[2]) * plane;
        take(part);
      }
    }
  }
}

// Calls take(index in `whole`, x fastest; index of the block's word counted from part.first) for each voxel of the part.
template <typename Take>
void for_each_voxel(const BlockPart& part, const VoxelBox& whole, int n, const Take& take) {
  for (int z = part.begin[2]; z < part.end[2]; ++z) {
    for (int y = part.begin[1]; y < part.end[1]; ++y) {
      for (int x = part.begin[0]; x < part.end[0]; ++x) {
        const int word = x - part.low[0] + n * (y - part.low[1] + n * (z - part.begin[2]));
        const int index = x - whole.low[0] + whole.size[0] * (y - whole.low[1] + whole.size[1] * (z - whole.low[2]));
        take(static_cast<std::size_t>(index), static_cast<std::size_t>(word));
      }
    }
  }
}

// In pieces of whole words of every kind.
std::vector<std::uint8_t> read(Device& device, std::uint64_t address, std::size_t bytes) {
  constexpr std::size_t kPiece = 36;
  const std::size_t max_bytes = device.agreed().max_payload_bytes / kPiece * kPiece;
  std::vector<std::uint8_t> out;
  while (out.size() < bytes) {
    const auto piece = device.read_memory(address + out.size(), std::min(max_bytes, bytes - out.size()));
    out.insert(out.end(), piece.begin(), piece.end());
  }
  return out;
}

std::uint64_t irradiance_address(const BlockPart& part, int n) {
  const auto words = static_cast<std::uint64_t>(n) * static_cast<std::uint64_t>(n) * static_cast<std::uint64_t>(n);
  return wire::kIrradiance.base + (part.block * words + part.first) * wire::kIrradianceBytes;
}

std::uint64_t volume_address(const BlockPart& part, int n) {
  const auto words = static_cast<std::uint64_t>(n) * static_cast<std::uint64_t>(n) * static_cast<std::uint64_t>(n);
  return wire::kVolume.base + (part.block * words + part.first) * wire::kVoxelBits / 8;
}

std::uint64_t sums_address(const BlockPart& part, int n) {
  return volume_address(part, n) - wire::kVolume.base + wire::kSums.base;
}

// Voxels of a box as they stand on the board, channel by channel.
struct Voxels {
  VoxelBox box;
  std::vector<std::uint16_t> densities, codes;
  std::vector<std::uint8_t> tags;
};

Voxels read_voxels(Device& device, const VoxelBox& box, Dims blocks, int n) {
  Voxels out{box, std::vector<std::uint16_t>(count(box)), std::vector<std::uint16_t>(count(box)),
             std::vector<std::uint8_t>(count(box))};
  for_each_block(box, blocks, n, [&](const BlockPart& part) {
    const auto bytes = read(device, volume_address(part, n), wire::packed36_bytes(part.words));
    for_each_voxel(part, box, n, [&](std::size_t index, std::size_t word) {
      const wire::Voxel voxel = wire::to_voxel(wire::load36(bytes, word));
      out.densities[index] = voxel.density;
      out.codes[index] = voxel.gradient;
      out.tags[index] = voxel.tag;
    });
  });
  return out;
}

// Whole blocks: those that hold `box`, and `above` more above them on each axis.
VoxelBox whole_blocks(const VoxelBox& box, int above, int n, Dims dims) {
  VoxelBox out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.low[axis] = box.low[axis] / n * n;
    const int end = ((box.low[axis] + box.size[axis] - 1) / n + 1 + above) * n;
    out.size[axis] = std::min(dims[axis], end) - out.low[axis];
  }
  return out;
}

template <typename Take>
void for_each_index(const VoxelBox& box, const VoxelBox& whole, const Take& take) {
  for (int z = 0; z < box.size[2]; ++z) {
    for (int y = 0; y < box.size[1]; ++y) {
      for (int x = 0; x < box.size[0]; ++x) {
        const int ax = x + box.low[0] - whole.low[0], ay = y + box.low[1] - whole.low[1],
                  az = z + box.low[2] - whole.low[2];
        take(static_cast<std::size_t>(x + box.size[0] * (y + box.size[1] * z)),
             static_cast<std::size_t>(ax + whole.size[0] * (ay + whole.size[1] * az)));
      }
    }
  }
}

}  // namespace

std::vector<float> Board::read_volume(const VoxelBox& box) {
  const auto lock = state_->begin();
  const LoadedVolume& volume = state_->loaded("read_volume()");
  check(box, volume.dims);
  const Voxels voxels = read_voxels(state_->device, box, volume.blocks, state_->info.block_voxels);
  std::vector<float> values(count(box));
  const double unit = (volume.range.high - volume.range.low) / wire::kDensityMax;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>(volume.range.low + voxels.densities[i] * unit);
  }
  return values;
}

void Board::write_volume(const VoxelBox& box, std::span<const float> values) {
  const auto lock = state_->begin();
  LoadedVolume& volume = state_->loaded("write_volume()");
  check(box, volume.dims);
  check_values(box, values, -std::numeric_limits<double>::infinity());
  const int n = state_->info.block_voxels;
  // The filter changes the gradients one voxel around the box, and looks two voxels around it. What a block holds counts
  // also the voxels of the next one's face.
  const VoxelBox changed = grown(box, 1, volume.dims);
  const VoxelBox written = whole_blocks(changed, 0, n, volume.dims);
  VoxelBox needed = whole_blocks(grown(box, 2, volume.dims), 0, n, volume.dims);
  const VoxelBox above = whole_blocks(changed, 1, n, volume.dims);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int end = std::max(needed.low[axis] + needed.size[axis], above.low[axis] + above.size[axis]);
    needed.size[axis] = end - needed.low[axis];
  }
  Voxels voxels = read_voxels(state_->device, needed, volume.blocks, n);

  VolumeView view{.samples = std::as_bytes(values), .type = SampleType::kFloat32, .dims = box.size};
  const auto densities = to_densities(view, volume.range);
  for_each_index(box, needed, [&](std::size_t of, std::size_t at) { voxels.densities[at] = densities[of]; });
  view = {.samples = std::as_bytes(std::span<const std::uint16_t>(voxels.densities)),
          .type = SampleType::kUint12,
          .dims = needed.size,
          .spacing = volume.relative_spacing};
  if (volume.gradients) {
    const auto codes = gradient_codes(view, {0, wire::kDensityMax}, state_->tables.codebook(), state_->threads);
    for_each_index(changed, needed, [&](std::size_t, std::size_t at) { voxels.codes[at] = codes[at]; });
  }

  const VoxelBlocks blocks(needed.size, n, voxels.densities, voxels.codes, voxels.tags);
  std::vector<std::uint8_t> bytes;
  for_each_block(written, volume.blocks, n, [&](const BlockPart& part) {
    std::array<int, 3> local{};
    for (std::size_t axis = 0; axis < 3; ++axis) local[axis] = (part.low[axis] - needed.low[axis]) / n;
    const auto block =
        static_cast<std::size_t>(local[0] + blocks.blocks()[0] * (local[1] + blocks.blocks()[1] * local[2]));
    blocks.pack(block, bytes);
    state_->write_block(part.block, bytes);
    volume.statistics[part.block] = blocks.statistics(block);
  });
  state_->find_flags(volume);
  state_->check_fence();
}

void Board::clear_irradiance(double unit) {
  const auto lock = state_->begin();
  if (!(std::isfinite(unit) && unit > 0)) throw BadArgument("unit", "a finite number above 0", number_text(unit));
  state_->loaded("clear_irradiance()");
  state_->device.write_register(wire::reg::kControl, wire::kControlClearIrradiance);
  state_->irradiance_unit = unit;
}

std::vector<float> Board::read_irradiance() {
  const auto lock = state_->begin();
  return state_->read_irradiance({{0, 0, 0}, state_->loaded("read_irradiance()").dims});
}

std::vector<float> Board::read_irradiance(const VoxelBox& box) {
  const auto lock = state_->begin();
  return state_->read_irradiance(box);
}

std::vector<float> Board::State::read_irradiance(const VoxelBox& box) {
  const LoadedVolume& of = loaded("read_irradiance()");
  if (irradiance_unit <= 0) throw Rejected("read_irradiance() needs light: illuminate() or clear_irradiance() first");
  check(box, of.dims);
  const int n = info.block_voxels;
  std::vector<float> out(count(box));
  for_each_block(box, of.blocks, n, [&](const BlockPart& part) {
    const auto bytes = read(device, irradiance_address(part, n), part.words * wire::kIrradianceBytes);
    for_each_voxel(part, box, n, [&](std::size_t index, std::size_t word) {
      out[index] =
          static_cast<float>(wire::load<std::uint32_t>(bytes, word * wire::kIrradianceBytes) * irradiance_unit);
    });
  });
  return out;
}

void Board::clear_sums(double unit) {
  const auto lock = state_->begin();
  if (!(std::isfinite(unit) && unit > 0)) throw BadArgument("unit", "a finite number above 0", number_text(unit));
  state_->loaded("clear_sums()");
  state_->device.write_register(wire::reg::kControl, wire::kControlClearSums);
  state_->sum_unit = unit;
}

std::vector<float> Board::read_sums(const VoxelBox& box) {
  const auto lock = state_->begin();
  const LoadedVolume& of = state_->loaded("read_sums()");
  if (state_->sum_unit <= 0) throw Rejected("read_sums() needs a unit: clear_sums() first");
  check(box, of.dims);
  const int n = state_->info.block_voxels;
  std::vector<float> out(count(box));
  for_each_block(box, of.blocks, n, [&](const BlockPart& part) {
    const auto bytes = read(state_->device, sums_address(part, n), wire::packed36_bytes(part.words));
    for_each_voxel(part, box, n, [&](std::size_t index, std::size_t word) {
      constexpr int kUnused = 64 - wire::kVoxelBits;
      const std::int64_t sum = static_cast<std::int64_t>(wire::load36(bytes, word) << kUnused) >> kUnused;
      out[index] = static_cast<float>(static_cast<double>(sum) * state_->sum_unit);
    });
  });
  return out;
}

void Board::write_irradiance(const VoxelBox& box, std::span<const float> values) {
  const auto lock = state_->begin();
  const LoadedVolume& volume = state_->loaded("write_irradiance()");
  if (state_->irradiance_unit <= 0) {
    throw Rejected("write_irradiance() needs a unit: illuminate() or clear_irradiance() first");
  }
  check(box, volume.dims);
  check_values(box, values, 0);
  const int n = state_->info.block_voxels;
  const double max_units = state_->info.wide ? 4294967295.0 : 2047.0;
  for_each_block(box, volume.blocks, n, [&](const BlockPart& part) {
    auto bytes = read(state_->device, irradiance_address(part, n), part.words * wire::kIrradianceBytes);
    for_each_voxel(part, box, n, [&](std::size_t index, std::size_t word) {
      const double units =
          std::min(std::round(static_cast<double>(values[index]) / state_->irradiance_unit), max_units);
      wire::store(std::span(bytes), word * wire::kIrradianceBytes, static_cast<std::uint32_t>(units));
    });
    state_->device.write_memory(irradiance_address(part, n), bytes);
  });
  state_->check_fence();
}

}  // namespace gicube
