#include "memory/irradiance_memory.h"

#include <algorithm>
#include <utility>

#include "gicube/wire/bytes.h"
#include "gicube/wire/memory_map.h"

namespace gicube::emu {

IrradianceMemory::IrradianceMemory(int block_voxels, std::uint32_t most)
    : n_(block_voxels),
      edge_(static_cast<std::size_t>(block_voxels) + 1),
      most_(most),
      block_bytes_(wire::kIrradianceBytes * static_cast<std::uint64_t>(block_voxels) *
                   static_cast<std::uint64_t>(block_voxels) * static_cast<std::uint64_t>(block_voxels)) {}

void IrradianceMemory::resize(const std::array<int, 3>& size) {
  size_ = size;
  ++changes_;
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks_[axis] = (size[axis] + n_ - 1) / n_;
    count *= static_cast<std::size_t>(blocks_[axis]);
  }
  words_ = std::vector<Words>(count);
  owned_.clear();
  owned_.resize(count);
}

void IrradianceMemory::clear() { resize(size_); }

std::size_t IrradianceMemory::stored_blocks() const {
  return static_cast<std::size_t>(
      std::count_if(words_.begin(), words_.end(), [](const Words& block) { return block != nullptr; }));
}

std::array<int, 3> IrradianceMemory::place(std::size_t block) const {
  const auto nx = static_cast<std::size_t>(blocks_[0]), ny = static_cast<std::size_t>(blocks_[1]);
  return {static_cast<int>(block % nx), static_cast<int>(block / nx % ny), static_cast<int>(block / (nx * ny))};
}

// The first thread that comes makes the block's words; who comes at the same time drops what it has made.
std::uint32_t* IrradianceMemory::storage(std::size_t block) {
  std::uint32_t* words = words_[block].load(std::memory_order_acquire);
  if (words != nullptr) return words;
  auto made = std::make_unique<std::uint32_t[]>(edge_ * edge_ * edge_);
  if (words_[block].compare_exchange_strong(words, made.get(), std::memory_order_acq_rel)) {
    owned_[block] = std::move(made);
    return owned_[block].get();
  }
  return words;
}

SharingBlocks IrradianceMemory::blocks_of(const Deposit& deposit) const {
  // Along each axis the blocks from the one before the lower voxel, if that lies on its far face, to the upper voxel's.
  std::array<int, 3> first{}, last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int low = deposit.voxel[axis];
    bool upper = false, lower = false;
    for (std::size_t i = 0; i < 8; ++i) {
      if (deposit.shares[i] != 0) ((i >> axis & 1) != 0 ? upper : lower) = true;
    }
    const int least = lower ? low : low + 1, greatest = upper ? low + 1 : low;
    first[axis] = least % n_ == 0 && least > 0 ? least / n_ - 1 : least / n_;
    last[axis] = std::min(greatest / n_, blocks_[axis] - 1);
  }
  SharingBlocks out;
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      for (int x = first[0]; x <= last[0]; ++x) {
        if (out.count == out.block.size()) return out;
        out.block[out.count++] = static_cast<std::uint32_t>(x + blocks_[0] * (y + blocks_[1] * z));
      }
    }
  }
  return out;
}

Deposited IrradianceMemory::add(const Deposit& deposit, std::uint32_t block) {
  const std::array<int, 3> at = place(block);
  std::uint32_t* const words = storage(block);
  Deposited sum;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::uint32_t share = deposit.shares[i];
    if (share == 0) continue;
    std::array<int, 3> local{};
    bool held = true, own = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      local[axis] = deposit.voxel[axis] + static_cast<int>(i >> axis & 1) - at[axis] * n_;
      held = held && local[axis] >= 0 && local[axis] <= n_;
      own = own && local[axis] < n_;
    }
    if (!held) continue;
    std::atomic_ref<std::uint32_t> word(words[index(local[0], local[1], local[2])]);
    std::uint32_t old = word.load(std::memory_order_relaxed), next = 0;
    do {
      next = share < most_ - old ? old + share : most_;
    } while (!word.compare_exchange_weak(old, next, std::memory_order_relaxed));
    if (!own) continue;
    sum.kept += next - old;
    sum.clipped += share - (next - old);
  }
  return sum;
}

void IrradianceMemory::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  ++changes_;
  for (std::size_t i = 0; i + 4 <= bytes.size(); i += 4) {
    const std::uint64_t at = offset + i;
    const std::array<int, 3> block = place(static_cast<std::size_t>(at / block_bytes_));
    const auto word = static_cast<int>(at % block_bytes_ / wire::kIrradianceBytes);
    Deposit one;
    one.voxel = {block[0] * n_ + word % n_, block[1] * n_ + word / n_ % n_, block[2] * n_ + word / (n_ * n_)};
    one.shares[0] = 1;
    const SharingBlocks sharing = blocks_of(one);
    const std::uint32_t value = std::min(wire::load<std::uint32_t>(bytes, i), most_);
    for (std::size_t b = 0; b < sharing.count; ++b) {
      const std::uint32_t holder = sharing.block[b];
      if (value == 0 && view(holder) == nullptr) continue;
      const std::array<int, 3> to = place(holder);
      storage(holder)[index(one.voxel[0] - to[0] * n_, one.voxel[1] - to[1] * n_, one.voxel[2] - to[2] * n_)] = value;
    }
  }
}

void IrradianceMemory::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  for (std::size_t i = 0; i + 4 <= out.size(); i += 4) {
    const std::uint64_t at = offset + i;
    const std::uint32_t* words = view(static_cast<std::size_t>(at / block_bytes_));
    const auto word = static_cast<int>(at % block_bytes_ / wire::kIrradianceBytes);
    const std::uint32_t value = words == nullptr ? 0 : words[index(word % n_, word / n_ % n_, word / (n_ * n_))];
    wire::store(out, i, value);
  }
}

}  // namespace gicube::emu
