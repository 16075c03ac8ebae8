// A coarse block of an out-of-core volume: one with fewer cells than voxels, which the DSP copies to them.
#include "command_fault.h"
#include "each_command.h"
#include "gicube/wire/coarse_block.h"
#include "gicube/wire/memory_map.h"
#include "levels/dsp_task.h"

namespace gicube::emu {

namespace {

// One voxel of a coarse block. Its word stays in a register along a row of the cell; it is shifted to its position
// among 36-bit words and stored.
constexpr DspLoop kCopyVoxel{"voxel of a coarse block", 0, 3, 2};

}  // namespace

CommandResult load_coarse(Card& card, Payload payload, Progress& /*work*/) {
  const auto header = header_of<wire::LoadCoarseHeader>(payload);
  card.check_volume();
  const std::size_t n = card.config.asic().block_voxels(), f = std::size_t{1} << (header.level & 7);
  const VolumeMemory& volume = card.aperture.volume();
  expect(header.block < volume.block_count(), "block", "one of the volume", header.block);
  expect(header.level >= 1 && header.level <= wire::kMaxCoarseLevel && 2 * f <= n, "level",
         "1..3 and cells of at most half a block", header.level);
  const std::size_t cells = n / f, count = cells * cells * cells, all = n * n * n;
  const std::size_t words = wire::packed36_bytes(count);
  const bool coloured = card.config.asic().voxel_format() != v1::density;
  if (payload.size() != wire::kLoadCoarseHeaderBytes + words + (coloured ? wire::kColourBytes * count : 0)) {
    refuse("payload", "12 bytes and the words (and colours) of " + std::to_string(count) + " cells", payload.size());
  }
  const auto cell_words = payload.subspan(wire::kLoadCoarseHeaderBytes, words);
  const auto cell_colours = payload.subspan(wire::kLoadCoarseHeaderBytes + words);
  std::vector<std::uint8_t> block(wire::packed36_bytes(all)), colours(coloured ? wire::kColourBytes * all : 0);
  for (std::size_t i = 0; i < all; ++i) {
    const std::size_t x = i % n, y = i / n % n, z = i / (n * n);
    const std::size_t cell = x / f + cells * (y / f + cells * (z / f));
    wire::store36(block, i, wire::load36(cell_words, cell));
    for (std::size_t c = 0; coloured && c < wire::kColourBytes; ++c) {
      colours[wire::kColourBytes * i + c] = cell_colours[wire::kColourBytes * cell + c];
    }
  }
  const auto write = [&](const wire::MemoryRegion& region, const std::vector<std::uint8_t>& bytes) {
    switch (card.write_memory(region.base + std::uint64_t{header.block} * bytes.size(), bytes)) {
      case Acceptance::kTaken: return;
      case Acceptance::kOutOfRange: refuse("block: expected one for which the card has room");
      case Acceptance::kTooMuchMemory: refuse("block: expected memory for it (gicube-board --max-memory)");
    }
  };
  write(wire::kVolume, block);
  if (coloured) write(wire::kColours, colours);
  return {.dsp_cycles = card.dsp_cycles(kCopyVoxel.setup() + all * kCopyVoxel.interval())};
}
}  // namespace gicube::emu
