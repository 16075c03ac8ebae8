#include "functional/simd/density_copy.h"

#include <algorithm>
#include <thread>

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
  const std::size_t part = voxels.size() / threads + 1;
  const auto copy = [&](unsigned t) {
    const std::size_t end = std::min(voxels.size(), (t + 1) * part);
    for (std::size_t i = t * part; i < end; ++i) densities_[i] = voxels[i].channel[0];
  };
  std::vector<std::jthread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back(copy, t);
  copy(0);
  place_ = densities_.data();
}

}  // namespace gicube::emu
