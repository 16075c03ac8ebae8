#include "memory/density_copy.h"

#include <algorithm>
#include <atomic>
#include <thread>

namespace gicube::emu {

void DensityCopy::clear() { *this = {}; }

void DensityCopy::follow(const VolumeMemory& volume, unsigned threads) {
  if (decoded_ == volume.decodings()) return;
  clear();
  decoded_ = volume.decodings();
  const auto edge = static_cast<std::size_t>(volume.block_voxels()) + 1;
  const std::size_t voxels = edge * edge * edge, blocks = volume.block_count();
  // Blocks that were never written share the first place, which stays zero.
  std::vector<std::size_t> stored;
  bool tagged = false;
  first_.assign(blocks, 0);
  for (std::size_t block = 0; block < blocks; ++block) {
    if (!volume.is_stored(block)) continue;
    stored.push_back(block);
    first_[block] = static_cast<std::int32_t>(stored.size() * voxels % (std::size_t{1} << 31));
    tagged = tagged || volume.view(block).tags != nullptr;
  }
  const std::size_t all = (stored.size() + 1) * voxels;
  fits_ = all < std::size_t{1} << 30;
  if (!fits_) return;
  densities_.assign(all + 1, 0);  // a pair is read at the last voxel too
  if (tagged) tags_.assign(all + 3, 0);

  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < stored.size(); i = next++) {
      const BlockView view = volume.view(stored[i]);
      const std::size_t to = (i + 1) * voxels;
      for (std::size_t v = 0; v < voxels; ++v) densities_[to + v] = view.voxels[v].channel[0];
      if (view.tags != nullptr) std::copy_n(view.tags, voxels, tags_.begin() + static_cast<std::ptrdiff_t>(to));
    }
  };
  std::vector<std::jthread> others;
  for (unsigned t = 1; t < threads && t < stored.size(); ++t) others.emplace_back(work);
  work();
}

}  // namespace gicube::emu
