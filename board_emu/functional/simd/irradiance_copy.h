// The irradiance as the interpolator's 16-bit words, block after block, for vectors.
//
// A host structure of the functional level, as DensityCopy. Blocks that no energy has reached take no memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "memory/irradiance_memory.h"
#include "memory/large_array.h"

namespace gicube::emu {

class IrradianceCopy {
 public:
  // Follows `memory`, of `blocks` blocks of `block_words` words, if it has changed. `narrow`: irradiance_word().
  void follow(const IrradianceMemory& memory, std::size_t blocks, std::size_t block_words, bool narrow);
  void clear() { *this = {}; }

  // 11.4; null if byte offsets would need more than 31 bits.
  const std::int16_t* words() const { return words_.empty() ? nullptr : words_.data(); }
  // Where each block's words begin; negative: it has none.
  const std::int32_t* first() const { return first_.data(); }

 private:
  std::uint64_t changes_ = 0;  // IrradianceMemory::changes() of the copy
  LargeArray<std::int16_t> words_;
  std::vector<std::int32_t> first_;
};

}  // namespace gicube::emu
