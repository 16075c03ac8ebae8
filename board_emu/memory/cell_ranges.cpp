#include "memory/cell_ranges.h"

#include <algorithm>
#include <bit>
#include <thread>

namespace gicube::emu {

CellRange CellRanges::range(const VolumeMemory& volume, const std::int16_t* densities,
                            const std::array<int, 3>& cell) const {
  const int cells_shift = std::countr_zero(static_cast<unsigned>(volume.block_voxels())) - kEdgeShift;
  const auto edge = static_cast<std::size_t>(volume.block_voxels()) + 1;
  std::array<std::size_t, 3> block{}, low{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    block[axis] = static_cast<std::size_t>(cell[axis] >> cells_shift);
    low[axis] = static_cast<std::size_t>(cell[axis] - (cell[axis] >> cells_shift << cells_shift)) << kEdgeShift;
  }
  const auto across = static_cast<std::size_t>(volume.blocks()[0]), down = static_cast<std::size_t>(volume.blocks()[1]);
  const std::size_t first = volume.first()[block[0] + across * (block[1] + down * block[2])];
  std::int16_t least = 32767, most = 0;
  unsigned tags = volume.decoded_tags().empty() ? 1 : 0;
  constexpr std::size_t kVoxels = (std::size_t{1} << kEdgeShift) + 1;
  for (std::size_t z = 0; z < kVoxels; ++z) {
    for (std::size_t y = 0; y < kVoxels; ++y) {
      const std::size_t row = first + low[0] + edge * (low[1] + y + edge * (low[2] + z));
      for (std::size_t i = row; i < row + kVoxels; ++i) {
        least = std::min(least, densities[i]);
        most = std::max(most, densities[i]);
      }
      if (volume.decoded_tags().empty()) continue;
      for (std::size_t i = row; i < row + kVoxels; ++i) tags |= 1u << volume.decoded_tags()[i];
    }
  }
  return {static_cast<std::uint16_t>(least >> kDensityFractionBits),
          static_cast<std::uint16_t>(most >> kDensityFractionBits), static_cast<std::uint8_t>(tags)};
}

void CellRanges::follow(const VolumeMemory& volume, const std::int16_t* densities, unsigned threads) {
  if (decoded_ == volume.decodings()) return;
  decoded_ = volume.decodings();
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size_[axis] = volume.blocks()[axis] * volume.block_voxels() >> kEdgeShift;
    count *= static_cast<std::size_t>(size_[axis]);
  }
  cells_.resize(count);
  const auto slice = static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
  const auto work = [&](unsigned thread) {
    for (int z = static_cast<int>(thread); z < size_[2]; z += static_cast<int>(threads)) {
      for (int y = 0; y < size_[1]; ++y) {
        for (int x = 0; x < size_[0]; ++x) {
          const std::size_t at = static_cast<std::size_t>(x) + static_cast<std::size_t>(y * size_[0]);
          cells_[at + slice * static_cast<std::size_t>(z)] = range(volume, densities, {x, y, z});
        }
      }
    }
  };
  std::vector<std::jthread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back(work, t);
  work(0);
}

}  // namespace gicube::emu
