// Checks of the volume's memory: the DSP reads blocks back, and a command that encounters a memory error is not
// executed.
#include <algorithm>
#include <string>
#include <vector>

#include "asic/memory_standards.h"
#include "asic/partition.h"
#include "command_fault.h"
#include "commands.h"
#include "gicube/wire/checksum.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

void DspCommands::add_memory_error(const MemoryError& error) {
  if (error.detected) {
    memory_errors_.push_back(error);
    return;
  }
  const auto place = aperture_.volume().find_bit(error.block, error.bit);
  if (place) aperture_.flip(*place);
}

// chosen: the first word that the command reads has the error, so nothing has changed.
void DspCommands::meet_memory_error() {
  const MemoryError error = memory_errors_.front();
  memory_errors_.pop_front();
  std::string text =
      std::string("the ") + memory_standard(config_).label + " reported an error that it could not correct";
  const auto place = aperture_.volume().find_bit(error.block, error.bit);
  if (place) {
    const std::size_t word_bits = 8 * aperture_.volume().block_bytes();
    const bool is_colour = place->bit >= word_bits;
    const std::size_t voxel =
        is_colour ? (place->bit - word_bits) / (8 * wire::kColourBytes) : place->bit / wire::kVoxelBits;
    text += ": block " + std::to_string(place->block) + (is_colour ? ", colour " : ", word ") + std::to_string(voxel);
  }
  throw CommandFault{wire::ErrorCode::kMemory, text};
}

CommandResult DspCommands::verify(std::span<const std::uint8_t> payload, Progress& work) {
  expect(payload.size() == wire::kVerifyCommandBytes, "payload", "16 bytes", payload.size());
  check_volume();
  const VolumeMemory& volume = aperture_.volume();
  const std::size_t first = wire::load<std::uint32_t>(payload, 4), count = wire::load<std::uint32_t>(payload, 8);
  expect(count >= 1 && count <= wire::kMaxVerifyBlocks, "count", "1..65536", count);
  if (first + count > volume.block_count()) {
    refuse("first + count", "at most " + std::to_string(volume.block_count()) + " blocks", first + count);
  }
  const std::vector<std::uint8_t> zeros(volume.block_bytes());
  const std::uint32_t never_written = wire::crc32c(zeros);
  std::vector<std::uint8_t> room;
  CommandResult result{.asic_ps = reading_time(first, count), .up_bytes = 4 * count};
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

// Each channel streams the stored blocks of its processors, one tile of four voxels at a time.
Picoseconds DspCommands::reading_time(std::size_t first, std::size_t count) const {
  constexpr std::uint64_t kTileVoxels = 4;
  const dram::Standard memory = memory_standard(config_);
  const VolumeMemory& volume = aperture_.volume();
  const unsigned processors = config_.asic().processors(), sharing = memory.sharing;
  const Partition partition(config_.asic(), volume.blocks());
  std::vector<std::uint64_t> blocks(processors);  // per channel
  for (std::size_t block = first; block < first + count; ++block) {
    if (volume.is_stored(block)) ++blocks[partition.home(block).processor / sharing];
  }
  const auto n = static_cast<std::uint64_t>(volume.block_voxels());
  const std::uint64_t clocks =
      *std::max_element(blocks.begin(), blocks.end()) * (n * n * n / kTileVoxels) * memory.tile_clocks;
  const std::uint64_t core_khz = config_.asic().core_khz();
  return cycles_to_ps(ClockRatio(memory.clock_khz, core_khz).from(clocks), core_khz);
}

}  // namespace gicube::emu
