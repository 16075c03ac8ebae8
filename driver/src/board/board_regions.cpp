// Reads and writes boxes of the volume, the irradiance and the sums, in whole planes of the board's blocks.
#include <algorithm>
#include <cmath>

#include "encode/argument.h"
#include "encode/volume/gradients.h"
#include "encode/volume/samples.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};

void check(const VoxelBox& box, Dims dims) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    expect_within(std::string("box.low.") + kAxisNames[axis], box.low[axis], 0, dims[axis] - 1);
    expect_within(std::string("box.size.") + kAxisNames[axis], box.size[axis], 1, dims[axis] - box.low[axis]);
  }
}

std::size_t count(const VoxelBox& box) { return voxel_count(box.size); }

void check_values(const VoxelBox& box, std::span<const float> values, double min_value, std::size_t of_voxel = 1) {
  expect(values.size() == of_voxel * count(box), "values",
         fmt::format("{}, {} per voxel of the box", of_voxel * count(box), of_voxel), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && values[i] >= min_value) continue;
    const char* const expected = std::isfinite(min_value) ? "a finite number of at least 0" : "a finite number";
    expect(false, fmt::format("values[{}]", i), expected, static_cast<double>(values[i]));
  }
}

void check_room(const VoxelBox& box, std::span<float> values, std::size_t of_voxel = 1) {
  const std::size_t needed = of_voxel * count(box);
  expect(values.size() == needed, "values", fmt::format("room for {}, {} per voxel of the box", needed, of_voxel),
         values.size());
}

// The box with `more` voxels added on each side, clipped to the volume.
VoxelBox grown(const VoxelBox& box, int more, Dims dims) {
  VoxelBox out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.low[axis] = std::max(0, box.low[axis] - more);
    out.size[axis] = std::min(dims[axis], box.low[axis] + box.size[axis] + more) - out.low[axis];
  }
  return out;
}

std::size_t index_in(const VoxelBox& box, int x, int y, int z) {
  return index_of(box.size, x - box.low[0], y - box.low[1], z - box.low[2]);
}

// Calls take(index in a, index in b) for each voxel of a box that lies in both.
template <typename Take>
void for_each_index(const VoxelBox& box, const VoxelBox& a, const VoxelBox& b, const Take& take) {
  for (int z = box.low[2]; z < box.low[2] + box.size[2]; ++z) {
    for (int y = box.low[1]; y < box.low[1] + box.size[1]; ++y) {
      const std::size_t in_a = index_in(a, box.low[0], y, z), in_b = index_in(b, box.low[0], y, z);
      for (std::size_t x = 0; x < static_cast<std::size_t>(box.size[0]); ++x) take(in_a + x, in_b + x);
    }
  }
}

// The part of a box that is in one block, and the whole planes of the block that contain it. The planes are contiguous
// in the board's memory.
struct BlockPart {
  std::size_t block = 0;
  Dims low{};  // the block's least voxel
  VoxelBox part, planes;
};

// Calls take(part) for each block that contains a part of the box.
template <typename Take>
void for_each_block(const VoxelBox& box, Dims blocks, int n, const Take& take) {
  Dims first{}, end{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = box.low[axis] / n;
    end[axis] = (box.low[axis] + box.size[axis] - 1) / n + 1;
  }
  for_each_position(first, end, [&](const Dims& at) {
    BlockPart part;
    part.block = index_of(blocks, at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      part.low[axis] = at[axis] * n;
      part.part.low[axis] = std::max(box.low[axis], part.low[axis]);
      part.part.size[axis] = std::min(box.low[axis] + box.size[axis], part.low[axis] + n) - part.part.low[axis];
    }
    part.planes = {{part.low[0], part.low[1], part.part.low[2]}, {n, n, part.part.size[2]}};
    take(part);
  });
}

constexpr std::size_t kWholeWords = 36;  // bytes: whole words of 32 and of 36 bits

// A region of the board's memory with a word for each voxel of the blocks.
class Words {
 public:
  // `bricks`: null if the card stores the volume whole.
  Words(Device& device, const wire::MemoryRegion& region, const LoadedVolume& volume, int n, Bricks* bricks = nullptr)
      : device_(device), region_(region), blocks_(volume.blocks), n_(n), bricks_(bricks) {}

  // Calls take(index in the box, word).
  void read(const VoxelBox& box, const auto& take) {
    for_each_block(box, blocks_, n_, [&](const BlockPart& part) {
      const std::vector<std::uint8_t> bytes = read(part);
      for_each_index(part.part, box, part.planes, [&, is_32 = bits() == 32](std::size_t index, std::size_t word) {
        take(index, is_32 ? wire::load<std::uint32_t>(bytes, 4 * word) : wire::load36(bytes, word));
      });
    });
  }

  // Converts each word by value(word).
  void values(const VoxelBox& box, std::span<float> out, const auto& value) {
    read(box, [&](std::size_t index, std::uint64_t word) { out[index] = static_cast<float>(value(word)); });
  }

  // Writes words of 32 bits. Words outside the box are kept.
  void write(const VoxelBox& box, const auto& value) {
    for_each_block(box, blocks_, n_, [&](const BlockPart& part) {
      std::vector<std::uint8_t> bytes = read(part);
      for_each_index(part.part, box, part.planes, [&](std::size_t index, std::size_t word) {
        wire::store(std::span(bytes), 4 * word, std::uint32_t{value(index)});
      });
      if (bricks_ != nullptr) return bricks_->light().write(device_, part.block, offset(part), bytes);
      device_.write_memory(address(part), bytes);
    });
  }

 private:
  std::uint64_t bits() const {
    return region_.base >= wire::kIrradiance.base ? 8 * wire::kIrradianceBytes : wire::kVoxelBits;
  }

  std::uint64_t offset(const BlockPart& part) const {  // in its block, bytes
    const auto n = static_cast<std::uint64_t>(n_);
    return static_cast<std::uint64_t>(part.part.low[2] - part.low[2]) * n * n * bits() / 8;
  }
  std::uint64_t address(const BlockPart& part) const {
    const auto n = static_cast<std::uint64_t>(n_);
    return region_.base + part.block * n * n * n * bits() / 8 + offset(part);
  }

  std::vector<std::uint8_t> read(const BlockPart& part) {
    const std::size_t bytes = count(part.planes) * bits() / 8;
    if (bricks_ != nullptr) {
      const auto all =
          bits() == wire::kVoxelBits ? bricks_->read(part.block) : bricks_->light().read(device_, part.block);
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(offset(part));
      return {begin, begin + static_cast<std::ptrdiff_t>(bytes)};
    }
    return device_.read_memory(address(part), bytes, kWholeWords);
  }

  Device& device_;
  const wire::MemoryRegion& region_;
  const Dims blocks_;
  const int n_;
  Bricks* const bricks_;
};

// The whole blocks that contain `box`, and `above` more blocks above them on each axis.
VoxelBox whole_blocks(const VoxelBox& box, int above, int n, Dims dims) {
  VoxelBox out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.low[axis] = box.low[axis] / n * n;
    const int end = ((box.low[axis] + box.size[axis] - 1) / n + 1 + above) * n;
    out.size[axis] = std::min(dims[axis], end) - out.low[axis];
  }
  return out;
}

}  // namespace

std::vector<float> VolumeStore::read(const VoxelBox& box) {
  const auto lock = state_->begin();
  return state_->values_of(box, "read_volume()", 1, &BoardState::read_volume);
}

void VolumeStore::read(const VoxelBox& box, std::span<float> values) {
  const auto lock = state_->begin();
  state_->read_volume(box, values);
}

// The values of a box, which `read` reads.
std::vector<float> BoardState::values_of(const VoxelBox& box, const char* what, std::size_t of_voxel,
                                         void (BoardState::*read)(const VoxelBox&, std::span<float>)) {
  check(box, loaded(what).dims);
  std::vector<float> values(of_voxel * count(box));
  (this->*read)(box, values);
  return values;
}

void BoardState::read_volume(const VoxelBox& box, std::span<float> values) {
  const LoadedVolume& of = loaded("read_volume()");
  check(box, of.dims);
  check_room(box, values);
  const double unit = (of.range.high - of.range.low) / wire::kDensityMax;
  Words words(device, wire::kVolume, of, info.block_voxels, bricks.get());
  words.values(box, values, [&](std::uint64_t word) { return of.range.low + wire::to_voxel(word).density * unit; });
}

void VolumeStore::write(const VoxelBox& box, std::span<const float> values) {
  const auto lock = state_->begin();
  LoadedVolume& volume = state_->whole("write_volume()");
  check(box, volume.dims);
  check_values(box, values, -std::numeric_limits<double>::infinity());
  const int n = state_->info.block_voxels;
  // The gradient filter changes gradients up to one voxel outside the box, and reads up to two. Statistics of a block
  // include its +1 faces, which are in the next block.
  const VoxelBox changed = grown(box, 1, volume.dims);
  const VoxelBox written = whole_blocks(changed, 0, n, volume.dims);
  VoxelBox needed = whole_blocks(grown(box, 2, volume.dims), 0, n, volume.dims);
  const VoxelBox above = whole_blocks(changed, 1, n, volume.dims);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int end = std::max(needed.low[axis] + needed.size[axis], above.low[axis] + above.size[axis]);
    needed.size[axis] = end - needed.low[axis];
  }
  std::vector<std::uint16_t> all_densities(count(needed)), all_codes(count(needed));
  std::vector<std::uint8_t> tags(count(needed));
  Words(state_->device, wire::kVolume, volume, n).read(needed, [&](std::size_t index, std::uint64_t word) {
    const wire::Voxel voxel = wire::to_voxel(word);
    all_densities[index] = voxel.density;
    all_codes[index] = voxel.gradient;
    tags[index] = voxel.tag;
  });

  VolumeView view{.samples = std::as_bytes(values), .type = SampleType::kFloat32, .dims = box.size};
  const auto densities = to_densities(view, volume.range);
  for_each_index(box, box, needed, [&](std::size_t of, std::size_t at) { all_densities[at] = densities[of]; });
  view = {.samples = std::as_bytes(std::span<const std::uint16_t>(all_densities)),
          .type = SampleType::kUint12,
          .dims = needed.size,
          .spacing = volume.relative_spacing};
  if (volume.gradients) {
    const auto codes = gradient_codes(view, {0, wire::kDensityMax}, state_->tables.codebook(), state_->threads);
    for_each_index(changed, changed, needed, [&](std::size_t, std::size_t at) { all_codes[at] = codes[at]; });
  }

  const VoxelBlocks blocks(needed.size, n, {all_densities, all_codes, tags, {}});
  std::vector<std::uint8_t> bytes;
  for_each_block(written, volume.blocks, n, [&](const BlockPart& part) {
    const VoxelBox all{{}, blocks.blocks()};
    const std::size_t block = index_in(all, (part.low[0] - needed.low[0]) / n, (part.low[1] - needed.low[1]) / n,
                                       (part.low[2] - needed.low[2]) / n);
    blocks.pack(block, bytes);
    state_->write_block(part.block, bytes);
    volume.statistics[part.block] = blocks.statistics(block);
  });
  state_->find_flags(volume);
  state_->check_fence();
}

void BoardState::clear_words(const char* what, std::uint32_t bits, double unit, double& kept_unit) {
  expect(std::isfinite(unit) && unit > 0, "unit", "a finite number above 0", unit);
  const bool irradiance = bits == wire::kControlClearIrradiance;
  irradiance ? loaded(what) : whole(what);
  device.write_register(wire::reg::kControl, bits);
  if (bricks) bricks->light().clear();
  kept_unit = unit;
}

void Illuminator::clear(double unit) {
  const auto lock = state_->begin();
  state_->clear_words("clear_irradiance()", wire::kControlClearIrradiance, unit, state_->irradiance_unit);
}

void Illuminator::clear_sums(double unit) {
  const auto lock = state_->begin();
  state_->clear_words("clear_sums()", wire::kControlClearSums, unit, state_->sum_unit);
}

std::vector<float> Illuminator::read() {
  const auto lock = state_->begin();
  return state_->irradiance_of({{0, 0, 0}, state_->loaded("read_irradiance()").dims});
}

std::vector<float> Illuminator::read(const VoxelBox& box) {
  const auto lock = state_->begin();
  return state_->irradiance_of(box);
}

std::vector<float> BoardState::irradiance_of(const VoxelBox& box) {
  const auto words = static_cast<std::size_t>(info.irradiance_words);
  return values_of(box, "read_irradiance()", words, &BoardState::read_irradiance);
}

void Illuminator::read(const VoxelBox& box, std::span<float> values) {
  const auto lock = state_->begin();
  state_->read_irradiance(box, values);
}

void BoardState::read_irradiance(const VoxelBox& box, std::span<float> out) {
  const LoadedVolume& of = loaded("read_irradiance()");
  if (irradiance_unit <= 0)
    throw Rejected("read_irradiance() needs light: call illuminate() or clear_irradiance() first");
  if (info.irradiance_words > 1) whole("read_irradiance()");  // BrickLight keeps one word per voxel
  check(box, of.dims);
  const auto count_of_words = static_cast<std::size_t>(info.irradiance_words);
  check_room(box, out, count_of_words);
  for (std::size_t colour = 0; colour < count_of_words; ++colour) {
    Words words(device, wire::irradiance_region(colour), of, info.block_voxels, bricks.get());
    words.read(box, [&](std::size_t index, std::uint64_t word) {
      out[index * count_of_words + colour] = static_cast<float>(static_cast<double>(word) * irradiance_unit);
    });
  }
}

void Illuminator::write(const VoxelBox& box, std::span<const float> values) {
  const auto lock = state_->begin();
  const LoadedVolume& volume = state_->loaded("write_irradiance()");
  const double unit = state_->irradiance_unit;
  if (unit <= 0) throw Rejected("write_irradiance() needs a unit: call illuminate() or clear_irradiance() first");
  check(box, volume.dims);
  const auto count_of_words = static_cast<std::size_t>(state_->info.irradiance_words);
  if (state_->info.irradiance_words > 1) state_->whole("write_irradiance()");
  check_values(box, values, 0, count_of_words);
  const double max_units = state_->info.wide ? 4294967295.0 : 2047.0;
  for (std::size_t colour = 0; colour < count_of_words; ++colour) {
    Words words(state_->device, wire::irradiance_region(colour), volume, state_->info.block_voxels,
                state_->bricks.get());
    words.write(box, [&](std::size_t index) {
      const auto value = static_cast<double>(values[index * count_of_words + colour]);
      return static_cast<std::uint32_t>(std::min(std::round(value / unit), max_units));
    });
  }
  state_->check_fence();
}

std::vector<float> Illuminator::read_sums(const VoxelBox& box) {
  const auto lock = state_->begin();
  return state_->values_of(box, "read_sums()", 1, &BoardState::read_sums);
}

void Illuminator::read_sums(const VoxelBox& box, std::span<float> values) {
  const auto lock = state_->begin();
  state_->read_sums(box, values);
}

void BoardState::read_sums(const VoxelBox& box, std::span<float> values) {
  const LoadedVolume& of = whole("read_sums()");
  if (sum_unit <= 0) throw Rejected("read_sums() needs a unit: call clear_sums() first");
  check(box, of.dims);
  check_room(box, values);
  Words words(device, wire::kSums, of, info.block_voxels);
  words.values(box, values, [&](std::uint64_t word) {
    constexpr int kUnused = 64 - wire::kVoxelBits;
    const std::int64_t sum = static_cast<std::int64_t>(word << kUnused) >> kUnused;
    return static_cast<double>(sum) * sum_unit;
  });
}

}  // namespace gicube
