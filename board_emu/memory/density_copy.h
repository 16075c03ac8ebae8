// The volume's densities and tags without gradients, in one array: what rays without colour read. A quarter of the decoded
// voxels' bytes, and two neighbours along x lie in one 32-bit word.
//
// A host structure of the functional level, made when the first such ray comes; the board has no such memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "memory/volume_memory.h"

namespace gicube::emu {

class DensityCopy {
 public:
  // Follows `volume`, which was decoded, if it was decoded anew since.
  void follow(const VolumeMemory& volume, unsigned threads);
  void clear();

  // False if it would have more words than 31-bit byte offsets reach.
  bool fits() const { return fits_; }
  // Blocks of (n+1)^3 densities, 12.3; block b's begin at index first()[b].
  const std::int16_t* densities() const { return densities_.data(); }
  // At the same places; null if every tag is 0. Four bytes may be read from any of them.
  const std::uint8_t* tags() const { return tags_.empty() ? nullptr : tags_.data(); }
  const std::vector<std::int32_t>& first() const { return first_; }

 private:
  std::uint64_t decoded_ = 0;  // VolumeMemory::decodings() of the copy
  bool fits_ = false;
  std::vector<std::int16_t> densities_;
  std::vector<std::uint8_t> tags_;
  std::vector<std::int32_t> first_;
};

}  // namespace gicube::emu
