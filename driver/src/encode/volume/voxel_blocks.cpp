#include "encode/volume/voxel_blocks.h"

#include <algorithm>

#include "encode/argument.h"
#include "encode/volume/samples.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

void check_count(const char* field, std::size_t expected, std::size_t got) {
  expect(got == expected, field, fmt::format("{}, one per voxel", expected), got);
}

constexpr std::size_t kDensities = std::size_t{wire::kDensityMax} + 1;

// For one tag, visible[d] is the number of entries below density d that have any opacity.
std::vector<std::uint16_t> count_visible(std::span<const wire::SegmentationEntry> entries) {
  std::vector<std::uint16_t> visible(entries.size() + 1);
  for (std::size_t d = 0; d < entries.size(); ++d) {
    visible[d + 1] = static_cast<std::uint16_t>(visible[d] + is_visible(entries[d]));
  }
  return visible;
}

}  // namespace

VoxelBlocks::VoxelBlocks(Dims dims, int n, const Voxels& voxels) : dims_(dims), n_(n), voxels_(voxels) {
  const auto& [densities, codes, tags, colours] = voxels;
  expect(n >= 2 && n % 2 == 0, "block_voxels", "an even number of at least 2", n);
  check_count("densities", voxel_count(dims), densities.size());
  if (!codes.empty()) check_count("codes", voxel_count(dims), codes.size());
  if (!tags.empty()) check_count("tags", voxel_count(dims), tags.size());
  if (!colours.empty()) check_count("colours", wire::kColourBytes * voxel_count(dims), colours.size());
  blocks_ = block_grid(dims, n);
  statistics_.resize(voxel_count(blocks_));
  stored_.resize(statistics_.size());
  for (std::size_t block = 0; block < statistics_.size(); ++block) {
    const Region touched = region(block, 1);
    statistics_[block] = find_statistics(touched);
    const BlockStatistics& found = statistics_[block];
    // Gradients reach one voxel further than the values, so a block of zeros may have some.
    static_assert(wire::kNoGradient == 0);
    stored_[block] = found.max_density != 0 || found.tags != 1 || has_nonzero(codes, 1, touched) ||
                     has_nonzero(colours, wire::kColourBytes, touched);
  }
}

VoxelBlocks::Region VoxelBlocks::region(std::size_t block, int overlap) const {
  const Dims at = position_of(block, blocks_);
  Region region{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    region.begin[axis] = static_cast<std::size_t>(at[axis] * n_);
    region.end[axis] = static_cast<std::size_t>(std::min((at[axis] + 1) * n_ + overlap, dims_[axis]));
  }
  return region;
}

std::size_t VoxelBlocks::row(std::size_t y, std::size_t z) const {
  return (z * static_cast<std::size_t>(dims_[1]) + y) * static_cast<std::size_t>(dims_[0]);
}

BlockStatistics VoxelBlocks::find_statistics(const Region& region) const {
  // 12 bits fit in a signed word, for which every x86-64 has vector instructions of minimum and maximum.
  std::int16_t low = wire::kDensityMax, high = 0;
  unsigned tags = voxels_.tags.empty() ? 1 : 0;
  for (std::size_t z = region.begin[2]; z < region.end[2]; ++z) {
    for (std::size_t y = region.begin[1]; y < region.end[1]; ++y) {
      const std::size_t begin = row(y, z) + region.begin[0], end = row(y, z) + region.end[0];
      for (std::size_t i = begin; i < end; ++i) {
        const auto density = static_cast<std::int16_t>(voxels_.densities[i]);
        low = std::min(low, density);
        high = std::max(high, density);
      }
      for (std::size_t i = begin; !voxels_.tags.empty() && i < end; ++i) tags |= 1u << voxels_.tags[i];
    }
  }
  return {static_cast<std::uint16_t>(low), static_cast<std::uint16_t>(high), static_cast<std::uint8_t>(tags)};
}

bool VoxelBlocks::has_nonzero(const auto& values, std::size_t of_voxel, const Region& region) const {
  if (values.empty()) return false;
  for (std::size_t z = region.begin[2]; z < region.end[2]; ++z) {
    for (std::size_t y = region.begin[1]; y < region.end[1]; ++y) {
      const std::size_t begin = row(y, z) + region.begin[0], count = region.end[0] - region.begin[0];
      const auto of_row = values.subspan(of_voxel * begin, of_voxel * count);
      if (std::ranges::any_of(of_row, [](auto value) { return value != 0; })) return true;
    }
  }
  return false;
}

void VoxelBlocks::pack(std::size_t block, std::vector<std::uint8_t>& out) const {
  const auto n = static_cast<std::size_t>(n_);
  const std::size_t words = wire::packed36_bytes(n * n * n);
  out.assign(words + (voxels_.colours.empty() ? 0 : wire::kColourBytes * n * n * n), 0);
  const Region inside = region(block, 0);
  for (std::size_t z = inside.begin[2]; z < inside.end[2]; ++z) {
    for (std::size_t y = inside.begin[1]; y < inside.end[1]; ++y) {
      // n is even, so a row begins on a whole byte and consists of pairs of voxels of nine bytes.
      std::size_t at = ((z - inside.begin[2]) * n + (y - inside.begin[1])) * n / 2 * 9;
      const std::size_t end = row(y, z) + inside.end[0];
      for (std::size_t i = row(y, z) + inside.begin[0]; i < end; i += 2, at += 9) {
        const std::uint64_t first = word(i), second = i + 1 < end ? word(i + 1) : 0;
        wire::store(std::span(out), at, first | second << wire::kVoxelBits);
        out[at + 8] = static_cast<std::uint8_t>(second >> (64 - wire::kVoxelBits));
      }
      if (voxels_.colours.empty()) continue;
      const std::size_t first = row(y, z) + inside.begin[0];
      const auto bytes = voxels_.colours.subspan(wire::kColourBytes * first, wire::kColourBytes * (end - first));
      const std::size_t place = words + wire::kColourBytes * ((z - inside.begin[2]) * n + (y - inside.begin[1])) * n;
      std::copy(bytes.begin(), bytes.end(), out.begin() + static_cast<std::ptrdiff_t>(place));
    }
  }
}

std::vector<std::uint8_t> find_empty_blocks(std::span<const BlockStatistics> blocks,
                                            std::span<const wire::SegmentationEntry> lut) {
  const std::size_t entries = wire::kSegmentationEntries;
  expect(lut.size() == entries, "segmentation LUT", fmt::format("{} entries", entries), lut.size());
  std::vector<std::vector<std::uint16_t>> visible;
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    visible.push_back(count_visible(lut.subspan(tag * kDensities, kDensities)));
  }
  std::vector<std::uint8_t> flags;
  flags.reserve(blocks.size());
  for (const BlockStatistics& block : blocks) {
    bool empty = true;
    for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
      if ((block.tags >> tag & 1) == 0) continue;
      empty = empty && visible[tag][std::size_t{block.max_density} + 1] == visible[tag][block.min_density];
    }
    flags.push_back(empty ? 1 : 0);
  }
  return flags;
}

std::vector<std::uint8_t> pack_flags(std::span<const std::uint8_t> flags) {
  std::vector<std::uint8_t> bytes((flags.size() + 7) / 8);
  for (std::size_t block = 0; block < flags.size(); ++block) {
    if (flags[block] != 0) bytes[block / 8] = static_cast<std::uint8_t>(bytes[block / 8] | 1u << block % 8);
  }
  return bytes;
}

}  // namespace gicube
