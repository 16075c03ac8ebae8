#include "memory_errors.h"

#include <string>

#include "asic/memory_standards.h"
#include "command_fault.h"

namespace gicube::emu {

void MemoryErrors::add(const MemoryError& error) {
  if (error.detected) {
    waiting_.push_back(error);
    return;
  }
  const auto place = card_.aperture.volume().find_bit(error.block, error.bit);
  if (place) card_.aperture.flip(*place);
}

// chosen: the first word that the command reads has the error, so nothing has changed.
void MemoryErrors::meet() {
  const MemoryError error = waiting_.front();
  waiting_.pop_front();
  std::string text =
      std::string("the ") + memory_standard(card_.config).label + " reported an error that it could not correct";
  const auto place = card_.aperture.volume().find_bit(error.block, error.bit);
  if (place) {
    const std::size_t word_bits = 8 * card_.aperture.volume().block_bytes();
    const bool is_colour = place->bit >= word_bits;
    const std::size_t voxel =
        is_colour ? (place->bit - word_bits) / (8 * wire::kColourBytes) : place->bit / wire::kVoxelBits;
    text += ": block " + std::to_string(place->block) + (is_colour ? ", colour " : ", word ") + std::to_string(voxel);
  }
  throw CommandFault{wire::ErrorCode::kMemory, text};
}

}  // namespace gicube::emu
