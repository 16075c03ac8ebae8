#include "functional/simd/cell_ranges.h"

#include <algorithm>

#include "gicube/parallel_for.h"

namespace gicube::emu {

void CellRanges::follow_block(const VolumeMemory& volume, std::size_t block) {
  const auto nx = static_cast<std::size_t>(volume.blocks()[0]), ny = static_cast<std::size_t>(volume.blocks()[1]);
  const auto across = static_cast<std::size_t>(size_[0]), slice = across * static_cast<std::size_t>(size_[1]);
  const auto voxels = static_cast<std::size_t>(volume.block_voxels()), cells = voxels >> kEdgeShift;
  CellRange* const out =
      cells_.data() + cells * (block % nx + across * (block / nx % ny) + slice * (block / (nx * ny)));
  const std::size_t first = volume.first()[block];
  if (first == 0) {  // the zero block
    for (std::size_t row = 0; row < cells * cells; ++row) {
      std::fill_n(out + across * (row % cells) + slice * (row / cells), cells, CellRange{});
    }
    return;
  }
  const std::uint16_t* const codes = volume.has_tags() ? volume.decoded_codes().data() + first : nullptr;
  find_ranges({volume.decoded_densities().data() + first, codes, voxels}, out, across, slice);
}

void CellRanges::follow(const VolumeMemory& volume, unsigned threads) {
  if (decoded_ == volume.decodings()) return;
  decoded_ = volume.decodings();
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size_[axis] = volume.blocks()[axis] * volume.block_voxels() >> kEdgeShift;
    count *= static_cast<std::size_t>(size_[axis]);
  }
  cells_.resize(count);
  constexpr std::size_t kRun = 1 << 15;  // cells; chosen: some 0.2 ms, several times the start of a thread
  const std::size_t blocks = volume.block_count(), run = std::max<std::size_t>(kRun / (count / blocks), 1);
  parallel_for_runs(blocks, run, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) follow_block(volume, block);
  });
}

}  // namespace gicube::emu
