// Compiled once for each instruction set of Highway (foreach_target); the host's best is chosen at run time.
#include "words/vector_targets.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "functional/simd/cell_ranges.cpp"
#include <hwy/foreach_target.h>  // includes this file again

#include "functional/simd/cell_ranges.h"

#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "gicube/parallel_for.h"
#include "words/words.h"

HWY_BEFORE_NAMESPACE();
namespace gicube::emu::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // no vectors

void find_ranges(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice) {
  find_ranges_one_by_one(block, out, across, slice);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kCell = std::size_t{1} << kCellEdgeShift;
static_assert(kCell * sizeof(std::int16_t) == sizeof(std::uint64_t), "a cell's voxels along x are a word of 64 bits");

// Joins a word's four voxels in the lowest of them.
template <class D, class Vector, typename Join>
HWY_INLINE Vector join_voxels(D d, Vector v, const Join& join) {
  const hn::Repartition<std::uint64_t, D> words;
  v = join(v, hn::BitCast(d, hn::ShiftRight<32>(hn::BitCast(words, v))));
  return join(v, hn::BitCast(d, hn::ShiftRight<16>(hn::BitCast(words, v))));
}

// Ranges of a row of cells along x, with least voxel `first`; `d`: lanes of voxels, at most a row of the block.
template <bool kTagged, class D>
HWY_INLINE void find_row(D d, const BlockCells& block, std::size_t first, CellRange* out) {
  const auto lowest = [](auto a, auto b) { return hn::Min(a, b); };
  const auto highest = [](auto a, auto b) { return hn::Max(a, b); };
  const auto either = [](auto a, auto b) { return hn::Or(a, b); };
  const std::size_t edge = block.voxels + 1, lanes = hn::Lanes(d);
  const hn::RebindToUnsigned<D> du;
  alignas(16) constexpr std::array<std::uint16_t, 8> kBits{1 | 2 << 8, 4 | 8 << 8};
  const auto bit_of_tag = hn::LoadDup128(du, kBits.data());
  for (std::size_t x = 0; x < block.voxels; x += lanes) {
    auto least = hn::Set(d, 32767), most = hn::Zero(d);
    auto tags = hn::Set(du, kTagged ? 0 : 1);
    for (std::size_t z = 0; z <= kCell; ++z) {
      for (std::size_t y = 0; y <= kCell; ++y) {
        for (std::size_t beside = 0; beside < 2; ++beside) {  // a cell has a fifth voxel, on its far face
          const std::size_t at = first + x + beside + edge * (y + edge * z);
          const auto densities = hn::LoadU(d, block.densities + at);
          least = hn::Min(least, densities);
          most = hn::Max(most, densities);
          if constexpr (kTagged) {
            const auto tag = hn::ShiftRight<kCodeBits>(hn::LoadU(du, block.codes + at));
            tags = hn::Or(tags, hn::TableLookupBytes(bit_of_tag, tag));  // the high byte is ignored
          }
        }
      }
    }
    alignas(64) std::array<std::int16_t, 32> min_of, max_of;
    alignas(64) std::array<std::uint16_t, 32> tags_of;
    hn::Store(hn::ShiftRight<kDensityFractionBits>(join_voxels(d, least, lowest)), d, min_of.data());
    hn::Store(hn::ShiftRight<kDensityFractionBits>(join_voxels(d, most, highest)), d, max_of.data());
    hn::Store(join_voxels(du, tags, either), du, tags_of.data());
    for (std::size_t i = 0; i < lanes; i += kCell) {
      *out++ = {static_cast<std::uint16_t>(min_of[i]), static_cast<std::uint16_t>(max_of[i]),
                static_cast<std::uint8_t>(tags_of[i])};
    }
  }
}

template <std::size_t kLanes>
void find_with(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice) {
  const hn::CappedTag<std::int16_t, kLanes> d;
  const std::size_t edge = block.voxels + 1;
  for (std::size_t z = 0; z < block.voxels; z += kCell) {
    for (std::size_t y = 0; y < block.voxels; y += kCell) {
      CellRange* const row = out + across * (y / kCell) + slice * (z / kCell);
      const std::size_t first = edge * (y + edge * z);
      block.codes == nullptr ? find_row<false>(d, block, first, row) : find_row<true>(d, block, first, row);
    }
  }
}

void find_ranges(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice) {
  switch (block.voxels) {
    case 8: return find_with<8>(block, out, across, slice);
    case 16: return find_with<16>(block, out, across, slice);
    default: return find_with<32>(block, out, across, slice);
  }
}

#endif
}  // namespace gicube::emu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gicube::emu {

void find_ranges_one_by_one(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice) {
  constexpr std::size_t kVoxels = (std::size_t{1} << kCellEdgeShift) + 1;
  const std::size_t edge = block.voxels + 1, cells = block.voxels >> kCellEdgeShift;
  const auto range = [&](std::size_t first) {
    std::int16_t least = 32767, most = 0;
    unsigned tags = 0;
    for (std::size_t i = 0; i < kVoxels * kVoxels * kVoxels; ++i) {
      const std::size_t at = first + i % kVoxels + edge * (i / kVoxels % kVoxels + edge * (i / (kVoxels * kVoxels)));
      least = std::min(least, block.densities[at]);
      most = std::max(most, block.densities[at]);
      tags |= 1u << (block.codes == nullptr ? 0 : tag_of(block.codes[at]));
    }
    return CellRange{static_cast<std::uint16_t>(least >> kDensityFractionBits),
                     static_cast<std::uint16_t>(most >> kDensityFractionBits), static_cast<std::uint8_t>(tags)};
  };
  for (std::size_t i = 0; i < cells * cells * cells; ++i) {
    const std::size_t x = i % cells, y = i / cells % cells, z = i / (cells * cells);
    out[x + across * y + slice * z] = range((x + edge * (y + edge * z)) << kCellEdgeShift);
  }
}

HWY_EXPORT(find_ranges);

void find_ranges(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice) {
  HWY_DYNAMIC_DISPATCH(find_ranges)(block, out, across, slice);
}

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
#endif
