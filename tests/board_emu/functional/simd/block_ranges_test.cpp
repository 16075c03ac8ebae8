#include "functional/simd/cell_ranges.h"

#include "instruction_sets.h"
#include "test.h"

namespace gicube::emu {
namespace {

// Densities and tags of a block, most of them one and the same, so that a voxel left out or too many changes a range.
struct Voxels {
  Voxels(std::size_t edge, std::mt19937& random) : densities(edge * edge * edge), codes(edge * edge * edge) {
    for (std::size_t i = 0; i < densities.size(); ++i) {
      densities[i] = static_cast<std::int16_t>(random() % 90 == 0 ? random() % 32761 : 16000);
      const unsigned tag = random() % 90 == 0 ? random() % 4 : 2;
      codes[i] = static_cast<std::uint16_t>(tag << kCodeBits | random() % 2048);
    }
  }

  std::vector<std::int16_t> densities;
  std::vector<std::uint16_t> codes;
};

TEST(BlockRanges, AreThoseFoundVoxelByVoxelInEveryBlockSizeOnEveryInstructionSet) {
  on_every_target([] {
    std::mt19937 random(5);
    for (const std::size_t n : {8, 16, 32, 64}) {
      const Voxels voxels(n + 1, random);
      const std::size_t cells = n / 4, across = cells + 3, slice = across * (cells + 1);
      for (const std::uint16_t* codes : {static_cast<const std::uint16_t*>(nullptr), voxels.codes.data()}) {
        const BlockCells block{voxels.densities.data(), codes, n};
        std::vector<CellRange> got(slice * cells, {9, 9, 9}), expected = got;
        find_ranges(block, got.data(), across, slice);
        find_ranges_one_by_one(block, expected.data(), across, slice);
        ASSERT_EQ(got, expected) << n;
      }
    }
  });
}

TEST(BlockRanges, HaveTheVoxelsOfTheFurtherFacesToo) {
  for (const std::size_t corner : {std::size_t{0}, std::size_t{4}, std::size_t{8}}) {
    std::vector<std::int16_t> densities(9 * 9 * 9, 80);
    densities[corner * (1 + 9 + 81)] = 4095 << 3;
    std::vector<CellRange> cells(8);
    find_ranges({densities.data(), nullptr, 8}, cells.data(), 2, 4);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool holds = corner == 4 || i == (corner == 0 ? 0u : 7u);
      EXPECT_EQ(cells[i], (CellRange{10, static_cast<std::uint16_t>(holds ? 4095 : 10), 1})) << corner << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace gicube::emu
