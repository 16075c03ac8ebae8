#include "encode/volume/empty_flags.h"

#include <fmt/format.h>

#include "gicube/error.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

constexpr std::size_t kDensities = std::size_t{wire::kDensityMax} + 1;

// visible[d]: how many of one tag's entries below density d have any opacity.
std::vector<std::uint16_t> count_visible(std::span<const wire::SegmentationEntry> entries) {
  std::vector<std::uint16_t> visible(entries.size() + 1);
  for (std::size_t d = 0; d < entries.size(); ++d) {
    visible[d + 1] = static_cast<std::uint16_t>(visible[d] + (entries[d].opacity > 0 || entries[d].opacity_fine > 0));
  }
  return visible;
}

}  // namespace

std::vector<std::uint8_t> find_empty_blocks(std::span<const BlockStatistics> blocks,
                                            std::span<const wire::SegmentationEntry> lut) {
  if (lut.size() != wire::kSegmentationEntries) {
    throw BadArgument("segmentation LUT", fmt::format("{} entries", wire::kSegmentationEntries),
                      fmt::format("{}", lut.size()));
  }
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
