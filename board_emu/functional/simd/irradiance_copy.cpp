#include "functional/simd/irradiance_copy.h"

namespace gicube::emu {

void IrradianceCopy::follow(const IrradianceMemory& memory, std::size_t blocks, std::size_t block_words, bool narrow) {
  if (changes_ == memory.changes() && first_.size() == blocks) return;
  clear();
  const std::size_t words = memory.stored_blocks() * block_words + 1;  // a pair is read at the last too
  first_.assign(blocks, -1);
  changes_ = memory.changes();
  if (words >= std::size_t{1} << 30) return;
  words_.resize(words);
  words_.back() = 0;
  std::size_t at = 0;
  for (std::size_t block = 0; block < blocks; ++block) {
    const std::uint32_t* from = memory.view(block);
    if (from == nullptr) continue;
    first_[block] = static_cast<std::int32_t>(at);
    for (std::size_t i = 0; i < block_words; ++i) words_[at++] = irradiance_word(from[i], narrow);
  }
}

}  // namespace gicube::emu
