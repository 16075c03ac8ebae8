#include "functional/simd/irradiance_copy.h"

#include <algorithm>

namespace gicube::emu {

void IrradianceCopy::follow(std::span<const IrradianceMemory> memories, std::size_t blocks, std::size_t block_words,
                            bool narrow) {
  std::uint64_t changes = 0;  // each of them never decreases
  for (const IrradianceMemory& memory : memories) changes += memory.changes();
  if (changes_ == changes && first_.size() == blocks) return;
  clear();
  first_.assign(blocks, -1);
  changes_ = changes;
  for (std::size_t block = 0; block < blocks; ++block) {
    const bool any = std::ranges::any_of(memories, [&](const auto& memory) { return memory.view(block) != nullptr; });
    if (!any) continue;
    first_[block] = static_cast<std::int32_t>(plane_);
    plane_ += block_words;
  }
  // The last word is read as a pair, too; samples without irradiance read the first block's words and drop them.
  const std::size_t words = std::max(memories.size() * plane_, block_words) + 1;
  if (words >= std::size_t{1} << 30) return;
  words_.resize(words);
  std::ranges::fill(words_, std::int16_t{0});
  std::size_t plane = 0;
  for (const IrradianceMemory& memory : memories) {
    for (std::size_t block = 0; block < blocks; ++block) {
      const std::uint32_t* const from = memory.view(block);
      if (from == nullptr) continue;
      std::int16_t* const to = words_.data() + plane + first_[block];
      for (std::size_t i = 0; i < block_words; ++i) to[i] = irradiance_word(from[i], narrow);
    }
    plane += plane_;
  }
}

}  // namespace gicube::emu
