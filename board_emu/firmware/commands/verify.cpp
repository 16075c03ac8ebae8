// Checksums of the volume's blocks: the DSP reads them back.
#include <algorithm>
#include <string>
#include <vector>

#include "asic/memory_standards.h"
#include "asic/partition.h"
#include "command_fault.h"
#include "each_command.h"
#include "gicube/wire/checksum.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

namespace {

// Each channel streams the stored blocks of its processors, one tile of four voxels at a time.
Picoseconds reading_time(const Card& card, std::size_t first, std::size_t count) {
  constexpr std::uint64_t kTileVoxels = 4;
  const dram::Standard memory = memory_standard(card.config);
  const VolumeMemory& volume = card.aperture.volume();
  const unsigned processors = card.config.asic().processors(), sharing = memory.sharing;
  const Partition partition(card.config.asic(), volume.blocks());
  std::vector<std::uint64_t> blocks(processors);  // per channel
  for (std::size_t block = first; block < first + count; ++block) {
    if (volume.is_stored(block)) ++blocks[partition.home(block).processor / sharing];
  }
  const auto n = static_cast<std::uint64_t>(volume.block_voxels());
  const std::uint64_t clocks =
      *std::max_element(blocks.begin(), blocks.end()) * (n * n * n / kTileVoxels) * memory.tile_clocks;
  const std::uint64_t core_khz = card.config.asic().core_khz();
  return cycles_to_ps(ClockRatio(memory.clock_khz, core_khz).from(clocks), core_khz);
}

}  // namespace

CommandResult verify_blocks(Card& card, Payload payload, Progress& work) {
  expect(payload.size() == wire::kVerifyCommandBytes, "payload", "16 bytes", payload.size());
  card.check_volume();
  const VolumeMemory& volume = card.aperture.volume();
  const std::size_t first = wire::load<std::uint32_t>(payload, 4), count = wire::load<std::uint32_t>(payload, 8);
  expect(count >= 1 && count <= wire::kMaxVerifyBlocks, "count", "1..65536", count);
  if (first + count > volume.block_count()) {
    refuse("first + count", "at most " + std::to_string(volume.block_count()) + " blocks", first + count);
  }
  const std::vector<std::uint8_t> zeros(volume.block_bytes());
  const std::uint32_t never_written = wire::crc32c(zeros);
  std::vector<std::uint8_t> room;
  CommandResult result{.asic_ps = reading_time(card, first, count), .up_bytes = 4 * count};
  result.payload.resize(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    if (work.cancel) throw CommandFault{wire::ErrorCode::kCancelled, ""};
    std::uint32_t sum = volume.is_stored(first + i) ? wire::crc32c(volume.packed(first + i, room)) : never_written;
    const BlockBytes& colours = volume.colours();
    if (colours.count() != 0 && colours.is_stored(first + i)) sum ^= wire::crc32c(colours[first + i]);
    wire::store(std::span(result.payload), 4 * i, sum);
  }
  return result;
}

}  // namespace gicube::emu
