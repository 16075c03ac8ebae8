#include "memory/accumulator_memory.h"

#include <algorithm>
#include <cstdlib>

#include "gicube/wire/voxel.h"

namespace gicube::emu {

void AccumulatorMemory::resize(const std::array<int, 3>& size) {
  if (waiting_ != nullptr) waiting_->forget();
  const std::size_t count = resize_blocks(size);
  blocks_words_.clear();
  blocks_words_.resize(count);
  bounds_.assign(count, 0);
}

void AccumulatorMemory::finish() {
  if (waiting_ != nullptr) waiting_->add_to(*this);
}

std::size_t AccumulatorMemory::stored_blocks() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(blocks_words_, [](const Words& words) { return words != nullptr; }));
}

void AccumulatorMemory::state(Archive& archive) {
  constexpr std::uint64_t kMaxBound = std::uint64_t{1} << 40;  // chosen: far above what a command leaves unclipped
  finish();
  archive.field("bounds", [&](Archive::Record& record) {
    for (std::uint64_t& bound : bounds_) record.at_most(bound, kMaxBound);
  });
  std::vector<std::size_t> stored;
  for (std::size_t block = 0; block < blocks_words_.size(); ++block) {
    if (blocks_words_[block] != nullptr) stored.push_back(block);
  }
  archive.list("with_words", stored, blocks_words_.size());
  for (const std::size_t block : stored) {
    archive.expect(block < blocks_words_.size(), "with_words", "blocks of the volume", block);
    if (archive.loads()) blocks_words_[block] = std::make_unique<std::int64_t[]>(voxels_and_faces());
    const std::span numbers(blocks_words_[block].get(), voxels_and_faces());
    archive.field("words" + std::to_string(block), [&](Archive::Record& record) { record(numbers); });
    const bool fits = std::ranges::all_of(
        numbers, [&](std::int64_t number) { return std::abs(number) < static_cast<std::int64_t>(kMaxBound); });
    archive.expect(fits, "words" + std::to_string(block), "numbers within the bounds", kMaxBound);
  }
}

std::int64_t* AccumulatorMemory::storage(std::size_t block) {
  auto& words = blocks_words_[block];
  if (words == nullptr) words = std::make_unique<std::int64_t[]>(voxels_and_faces());
  return words.get();
}

SharingBlocks AccumulatorMemory::blocks_of(const Deposit& deposit) const {
  SharingBlocks out;
  for (std::size_t i = 0; i < 8; ++i) {
    if (deposit.shares[i] == 0) continue;
    std::array<int, 3> at{};
    bool held = true;  // false: beyond the volume, so there is no word for the share
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = (deposit.voxel[axis] + static_cast<int>(i >> axis & 1)) / n_;
      held = held && at[axis] < blocks_[axis];
    }
    if (!held) continue;
    const auto block = static_cast<std::uint32_t>(block_at(at[0], at[1], at[2]));
    const auto end = out.block.begin() + static_cast<std::ptrdiff_t>(out.count);
    if (std::find(out.block.begin(), end, block) == end) out.block[out.count++] = block;
  }
  return out;
}

std::int64_t AccumulatorMemory::add(const Deposit& deposit, std::uint32_t block) {
  const std::array<int, 3> at = place(block);
  std::int64_t* const words = storage(block);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    if (deposit.shares[i] == 0) continue;
    std::array<int, 3> local{};
    bool own = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      local[axis] = deposit.voxel[axis] + static_cast<int>(i >> axis & 1) - at[axis] * n_;
      own = own && local[axis] >= 0 && local[axis] < n_;
    }
    if (!own) continue;
    const auto share = static_cast<std::int32_t>(deposit.shares[i]);
    words[index(local[0], local[1], local[2])] += share;
    sum += share;
  }
  return sum;
}

// Moves the partial sums beyond the blocks' far faces to the words that they belong to.
void AccumulatorMemory::gather_parts() {
  for (std::size_t block = 0; block < blocks_words_.size(); ++block) {
    if (blocks_words_[block] == nullptr) continue;
    std::int64_t* const words = blocks_words_[block].get();
    const std::array<int, 3> at = place(block);
    const auto move = [&](int x, int y, int z) {
      std::int64_t& part = words[index(x, y, z)];
      if (part == 0) return;
      const std::size_t owner = block_at(at[0] + x / n_, at[1] + y / n_, at[2] + z / n_);
      storage(owner)[index(x % n_, y % n_, z % n_)] += part;
      part = 0;
    };
    for (int a = 0; a <= n_; ++a) {
      for (int b = 0; b <= n_; ++b) {
        move(n_, a, b);
        move(a, n_, b);
        move(a, b, n_);
      }
    }
  }
}

// A word has partial sums in its block and in the seven blocks before it.
bool AccumulatorMemory::can_overflow() const {
  for (std::size_t block = 0; block < bounds_.size(); ++block) {
    const std::array<int, 3> at = place(block);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      std::array<int, 3> from = at;
      for (std::size_t axis = 0; axis < 3; ++axis) from[axis] = std::max(at[axis] - static_cast<int>(i >> axis & 1), 0);
      sum += bounds_[block_at(from[0], from[1], from[2])];
    }
    if (sum > static_cast<std::uint64_t>(wire::kMaxSum)) return true;
  }
  return false;
}

Overflow AccumulatorMemory::settle() {
  Overflow out;
  if (!can_overflow()) return out;
  finish();
  gather_parts();
  for (std::size_t block = 0; block < blocks_words_.size(); ++block) {
    std::int64_t* const words = blocks_words_[block].get();
    std::int64_t largest = 0;
    bounds_[block] = 0;
    if (words == nullptr) continue;
    for (std::size_t i = 0; i < voxels_and_faces(); ++i) {
      const std::int64_t value = words[i];
      largest = std::max(largest, std::abs(value));
      if (std::abs(value) <= wire::kMaxSum) continue;
      words[i] = std::clamp(value, -wire::kMaxSum, wire::kMaxSum);
      ++out.words;
      out.clipped += value - words[i];
    }
    bounds_[block] = static_cast<std::uint64_t>(std::min(largest, wire::kMaxSum));
  }
  return out;
}

// Reads a row of a block. Words on the block's near faces have partial sums in up to seven neighbours.
void AccumulatorMemory::read_row(std::size_t block, int y, int z, std::span<std::int64_t> row) const {
  std::ranges::fill(row, 0);
  const std::array<int, 3> at = place(block), local{0, y, z};
  for (std::size_t i = 0; i < 8; ++i) {
    std::array<int, 3> from = at, in = local;
    bool there = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((i >> axis & 1) == 0) continue;
      there = there && local[axis] == 0 && at[axis] > 0;
      --from[axis];
      in[axis] = n_;
    }
    if (!there) continue;
    const std::int64_t* const words = blocks_words_[block_at(from[0], from[1], from[2])].get();
    if (words == nullptr) continue;
    const std::int64_t* const part = words + index(in[0], in[1], in[2]);
    const std::size_t length = (i & 1) == 0 ? row.size() : 1;
    for (std::size_t x = 0; x < length; ++x) row[x] += part[x];
  }
}

void AccumulatorMemory::read(std::uint64_t offset, std::span<std::uint8_t> out) {
  finish();
  constexpr std::uint64_t kMask = (std::uint64_t{1} << wire::kVoxelBits) - 1;
  const std::uint64_t first = offset / 9 * 2, of_block = block_bytes() / 9 * 2;
  const auto n = static_cast<std::size_t>(n_);
  std::size_t block = static_cast<std::size_t>(first / of_block), word = static_cast<std::size_t>(first % of_block);
  std::vector<std::int64_t> row(n);
  for (std::size_t at = 0; at < out.size();) {  // in pairs, from an even word of a row on
    read_row(block, static_cast<int>(word / n % n), static_cast<int>(word / (n * n)), row);
    std::size_t x = word % n;
    word += n - x;
    for (; x < n && at < out.size(); x += 2, at += 9) {
      const auto even = static_cast<std::uint64_t>(row[x]) & kMask,
                 odd = static_cast<std::uint64_t>(row[x + 1]) & kMask;
      wire::store(out, at, even | odd << wire::kVoxelBits);
      out[at + 8] = static_cast<std::uint8_t>(odd >> (64 - wire::kVoxelBits));
    }
    if (word == of_block) word = 0, ++block;
  }
}

}  // namespace gicube::emu
