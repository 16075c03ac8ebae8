// The volume's densities alone, at the places of VolumeMemory::decoded(): a quarter of the bytes, and two neighbours along x
// lie in one 32-bit word. A volume that was decoded to densities alone needs no copy.
//
// A host structure of the functional level, made when enough rays come that read it; the board has no such memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "memory/large_array.h"
#include "memory/volume_memory.h"

namespace gicube::emu {

class DensityCopy {
 public:
  // Follows `volume`, which was decoded, if it was decoded anew since.
  void follow(const VolumeMemory& volume, unsigned threads);
  void clear();

  // 12.3; null if byte offsets would need more than 31 bits.
  const std::int16_t* densities() const { return place_; }

 private:
  std::uint64_t decoded_ = 0;  // VolumeMemory::decodings() of the copy
  LargeArray<std::int16_t> densities_;
  const std::int16_t* place_ = nullptr;
};

}  // namespace gicube::emu
