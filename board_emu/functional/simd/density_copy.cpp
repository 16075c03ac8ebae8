#include "functional/simd/density_copy.h"

#include <algorithm>

#include "gicube/parallel_for.h"

namespace gicube::emu {

void DensityCopy::clear() { *this = {}; }

void DensityCopy::follow(const VolumeMemory& volume, unsigned threads) {
  if (decoded_ == volume.decodings()) return;
  clear();
  decoded_ = volume.decodings();
  constexpr std::size_t kMax = std::size_t{1} << 30;
  if (const auto there = volume.decoded_densities(); !there.empty()) {
    if (there.size() < kMax) place_ = there.data();
    return;
  }
  const std::span<const DecodedVoxel> voxels = volume.decoded();
  if (voxels.size() >= kMax) return;
  densities_.resize(voxels.size() + 1);  // a pair is read at the last voxel too
  densities_.back() = 0;
  parallel_for_runs(voxels.size(), voxels.size() / threads + 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) densities_[i] = voxels[i].channel[0];
  });
  place_ = densities_.data();
}

}  // namespace gicube::emu
