// The functional level's fast way for segments that gather opacity alone: as many rays side by side as the host's vectors
// have lanes, over a copy of the densities. The same bits as integrate() (tests/board_emu/opacity_march_test).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "frame.h"
#include "gicube/wire/ray.h"
#include "memory/density_copy.h"
#include "pipeline/opacity_correction.h"

namespace gicube::emu {

struct OpacityTables {
  std::array<std::uint32_t, wire::kSegmentationEntries>
      depth{};  // of one voxel length, 8.24 in base 2; all ones: opaque
  std::array<std::uint64_t, OpacityCorrection::kSegments> exp2{};  // value, and in bits 32.. the fall to the next
  std::vector<std::int32_t> first;  // of each block in the copy; negative: an empty block to be leapt over
};

// What the vectors read.
struct OpacityField {
  const std::int16_t* densities;
  const std::uint8_t* tags;  // may be null
  const OpacityTables* tables;
  Point extent;
  std::int32_t threshold;
  std::int32_t edge;  // voxels of a block with its +1 face
  int block_shift;    // from position units to blocks
  std::int32_t across, slice;
};

class OpacityMarch {
 public:
  explicit OpacityMarch(const OpacityCorrection& correction);

  // Makes ready for `rays` rays of this frame, whose segmentation LUT was written `lut_writes` times and whose volume is
  // decoded. False if they must go the plain way: the frame asks for more than opacity, too few rays have come to be worth
  // the copy, or it would be too large.
  bool prepare(std::uint64_t rays, const Frame& frame, std::uint64_t lut_writes, unsigned threads);
  // Gives the copy's memory back.
  void clear();

  // Takes rays to their ends, in place, on the calling thread; those without flags are passed over.
  void trace(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters) const;

 private:
  const OpacityCorrection& correction_;
  DensityCopy copy_;
  OpacityTables tables_;
  std::uint64_t volume_ = 0;  // VolumeMemory::decodings()
  std::uint64_t rays_ = 0;    // that have come since
  std::uint64_t lut_writes_ = ~std::uint64_t{0};
};

}  // namespace gicube::emu
