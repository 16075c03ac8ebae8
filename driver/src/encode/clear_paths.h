// Pairs of elements with nothing between them: what the empty flags prove, so that no ray need be sent.
#pragma once

#include <cstdint>
#include <span>

#include "gicube/pair.h"
#include "gicube/wire/pair.h"

namespace gicube {

// The blocks of a volume and which of them hold nothing visible.
struct BlockFlags {
  Dims blocks{};
  int block_voxels = 0;
  std::span<const std::uint8_t> empty;  // one a block, x fastest; nonzero = every sample in it is invisible
};

// Whether every sample of every ray between the two elements lies in blocks flagged empty. The rays' hull is taken as that of
// the elements' axis-parallel bounds, widened by what the board's fixed-point steps of `step` voxels can stray, so that
// false may come back for a clear path, and true never for another.
bool is_clear(const wire::Element& a, const wire::Element& b, const BlockFlags& flags, double step);

// The sum that the DSP would make of such a pair, to the bit: every ray comes back with opacity 0.
PairFactor clear_factor(const wire::Element& a, const wire::Element& b, std::uint32_t id, const PairRequest& request,
                        Vec3 spacing);

}  // namespace gicube
