#include "encode/volume/coarse_block.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "gicube/wire/lut.h"
#include "gicube/wire/voxel.h"

namespace gicube {

namespace {

// Sums over the voxels of a cell.
struct Sum {
  std::uint32_t voxels = 0, density = 0, low = wire::kDensityMax, high = 0;
  std::array<std::uint32_t, wire::kTags> tags{};
  std::array<std::uint32_t, wire::kColourBytes> colour{};
  Vec3 gradient{};
};

std::uint32_t mean(std::uint32_t sum, std::uint32_t count) { return (sum + count / 2) / count; }

}  // namespace

CoarseBlock coarse_block(std::span<const std::uint8_t> packed, std::size_t n, const Dims& inside, bool coloured,
                         int level, const GradientCodebook& codebook) {
  const std::size_t f = std::size_t{1} << level, cells = n >> level, count = cells * cells * cells;
  const auto entries = codebook.entries();
  const std::span<const std::uint8_t> colours = packed.subspan(wire::packed36_bytes(n * n * n));
  std::vector<Sum> sums(count);
  const auto end = [&](std::size_t axis) { return static_cast<std::size_t>(inside[axis]); };
  for (std::size_t z = 0; z < end(2); ++z) {
    for (std::size_t y = 0; y < end(1); ++y) {
      Sum* const row = sums.data() + cells * (y / f + cells * (z / f));
      for (std::size_t x = 0; x < end(0); ++x) {
        const std::size_t i = x + n * (y + n * z);
        const wire::Voxel voxel = wire::to_voxel(wire::load36(packed, i));
        Sum& sum = row[x / f];
        ++sum.voxels;
        sum.density += voxel.density;
        sum.low = std::min<std::uint32_t>(sum.low, voxel.density);
        sum.high = std::max<std::uint32_t>(sum.high, voxel.density);
        ++sum.tags[voxel.tag];
        if (voxel.gradient != wire::kNoGradient) {
          const wire::GradientEntry& entry = entries[voxel.gradient];
          sum.gradient = sum.gradient + Vec3{1.0 * entry[0], 1.0 * entry[1], 1.0 * entry[2]};
        }
        for (std::size_t c = 0; coloured && c < wire::kColourBytes; ++c) {
          sum.colour[c] += colours[wire::kColourBytes * i + c];
        }
      }
    }
  }
  CoarseBlock out;
  out.packed.resize(wire::packed36_bytes(count));
  for (std::size_t cell = 0; cell < count; ++cell) {
    const Sum& sum = sums[cell];
    if (sum.voxels == 0) continue;  // beyond the volume
    const std::uint32_t density = mean(sum.density, sum.voxels);
    const auto tag = std::ranges::max_element(sum.tags) - sum.tags.begin();
    const wire::Voxel voxel{.density = static_cast<std::uint16_t>(density),
                            .gradient = codebook.nearest(sum.gradient),
                            .tag = static_cast<std::uint8_t>(tag)};
    wire::store36(out.packed, cell, wire::to_word(voxel));
    out.largest_error =
        std::max({out.largest_error, static_cast<int>(density - sum.low), static_cast<int>(sum.high - density)});
  }
  for (std::size_t cell = 0; coloured && cell < count; ++cell) {
    for (const std::uint32_t colour : sums[cell].colour) {
      out.packed.push_back(static_cast<std::uint8_t>(mean(colour, std::max(sums[cell].voxels, 1u))));
    }
  }
  return out;
}

}  // namespace gicube
