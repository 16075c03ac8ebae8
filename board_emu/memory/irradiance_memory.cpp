#include "memory/irradiance_memory.h"

#include <algorithm>
#include <utility>

#include "gicube/wire/bytes.h"

namespace gicube::emu {

void IrradianceMemory::resize(const std::array<int, 3>& size) {
  ++changes_;
  const std::size_t count = resize_blocks(size);
  words_ = std::vector<Words>(count);
  owned_.clear();
  owned_.resize(count);
}

std::size_t IrradianceMemory::stored_blocks() const {
  return static_cast<std::size_t>(
      std::count_if(words_.begin(), words_.end(), [](const Words& block) { return block != nullptr; }));
}

// The first thread to arrive creates the block's words; a thread that comes second frees its own.
std::uint32_t* IrradianceMemory::storage(std::size_t block) {
  std::uint32_t* words = words_[block].load(std::memory_order_acquire);
  if (words != nullptr) return words;
  auto made = std::make_unique<std::uint32_t[]>(voxels_and_faces());
  if (words_[block].compare_exchange_strong(words, made.get(), std::memory_order_acq_rel)) {
    owned_[block] = std::move(made);
    return owned_[block].get();
  }
  return words;
}

void IrradianceMemory::state(Archive& archive) {
  ++changes_;
  std::vector<std::size_t> stored;
  for (std::size_t block = 0; block < words_.size(); ++block) {
    if (words_[block] != nullptr) stored.push_back(block);
  }
  archive.list("stored", stored, words_.size());
  for (const std::size_t block : stored) {
    archive.expect(block < words_.size(), "stored", "blocks of the volume", block);
    archive.field("block" + std::to_string(block), [&](Archive::Record& record) {
      for (std::uint32_t& word : std::span(storage(block), voxels_and_faces())) record.at_most(word, most_);
    });
  }
}

SharingBlocks IrradianceMemory::blocks_of(const Deposit& deposit) const {
  // Along each axis: from the block before the lower voxel's, if that voxel is on its far face, to the upper voxel's
  // block.
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
        out.block[out.count++] = static_cast<std::uint32_t>(block_at(x, y, z));
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
  const std::uint64_t block_bytes = this->block_bytes();
  for (std::size_t i = 0; i + 4 <= bytes.size(); i += 4) {
    const std::uint64_t at = offset + i;
    const std::array<int, 3> block = place(static_cast<std::size_t>(at / block_bytes));
    const auto word = static_cast<int>(at % block_bytes / wire::kIrradianceBytes);
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

void IrradianceMemory::drop(std::size_t block) {
  if (view(block) == nullptr) return;  // then its copies are 0 too
  write(block * block_bytes(), std::vector<std::uint8_t>(static_cast<std::size_t>(block_bytes())));
  const std::span words(storage(block), voxels_and_faces());
  if (std::ranges::any_of(words, [](std::uint32_t word) { return word != 0; })) return;
  words_[block] = nullptr;
  owned_[block].reset();
}

void IrradianceMemory::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  const std::uint64_t block_bytes = this->block_bytes();
  for (std::size_t i = 0; i + 4 <= out.size(); i += 4) {
    const std::uint64_t at = offset + i;
    const std::uint32_t* words = view(static_cast<std::size_t>(at / block_bytes));
    const auto word = static_cast<int>(at % block_bytes / wire::kIrradianceBytes);
    const std::uint32_t value = words == nullptr ? 0 : words[index(word % n_, word / n_ % n_, word / (n_ * n_))];
    wire::store(out, i, value);
  }
}

}  // namespace gicube::emu
