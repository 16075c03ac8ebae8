// The irradiance as the interpolator's 16-bit words, block after block, for vectors.
//
// A host structure of the functional level. Blocks that no energy has reached take no memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "memory/irradiance_memory.h"
#include "memory/large_array.h"

namespace gicube::emu {

class IrradianceCopy {
 public:
  // Updates the copy if a memory has changed. `memories`: one per irradiance word, of `blocks` blocks with
  // `block_words` words. `narrow`: as in irradiance_word().
  void follow(std::span<const IrradianceMemory> memories, std::size_t blocks, std::size_t block_words, bool narrow);
  void clear() { *this = {}; }

  // 11.4; null if byte offsets would need more than 31 bits.
  const std::int16_t* words() const { return words_.empty() ? nullptr : words_.data(); }
  // Distance of a word of one memory to that of the next.
  std::size_t plane() const { return plane_; }
  // First words of the blocks in the first memory; negative: no memory has any.
  const std::int32_t* first() const { return first_.data(); }

 private:
  std::uint64_t changes_ = 0;  // sum of IrradianceMemory::changes() at the update
  std::size_t plane_ = 0;
  LargeArray<std::int16_t> words_;
  std::vector<std::int32_t> first_;
};

}  // namespace gicube::emu
