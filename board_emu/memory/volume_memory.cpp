#include "memory/volume_memory.h"

#include <algorithm>
#include <atomic>

#include "gicube/parallel_for.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/voxel.h"
#include "memory/block_decoder.h"

namespace gicube::emu {

namespace {

constexpr std::size_t kTagsBeyond = 3;  // so that the last tag too can be read as the low byte of a word

}  // namespace

VolumeMemory::VolumeMemory(int block_voxels)
    : Blocked(block_voxels), block_bytes_(wire::packed36_bytes(voxels_of_block())) {}

void VolumeMemory::resize(const std::array<int, 3>& size) {
  const std::size_t count = resize_blocks(size);
  packed_.clear();  // its blocks first: there may be no memory for both
  packed_.resize(count);
  stored_ = 0;
  stale_.assign(count, 0);
  first_.assign(count, 0);
  voxels_ = {};
  densities_ = {};
  tags_ = {};
  resized_ = true;
}

std::uint64_t VolumeMemory::bytes_to_write(std::uint64_t offset, std::uint64_t length) const {
  if (length == 0 || offset + length > bytes()) return 0;
  std::uint64_t fresh = 0;
  for (std::uint64_t block = offset / block_bytes_; block <= (offset + length - 1) / block_bytes_; ++block) {
    if (packed_[static_cast<std::size_t>(block)].empty()) ++fresh;
  }
  return fresh * block_bytes_;
}

std::uint64_t VolumeMemory::bytes_to_decode(const VolumeReads& reads) const {
  const bool anew = voxels_.empty() && (reads.gradients || densities_.empty());
  std::uint64_t blocks = anew ? 1 : 0;
  for (std::size_t block = 0; block < packed_.size(); ++block) {
    const bool has_place = !anew && first_[block] != 0;
    const bool read = reads.leapt_over.empty() || reads.leapt_over[block] == 0;
    if (!packed_[block].empty() && !has_place && read) ++blocks;
  }
  if (blocks == 0) return 0;
  // A vector that grows takes twice its size or what is asked for, beside what it has.
  const std::uint64_t have = anew ? 0 : places(), want = have + blocks * voxels_and_faces();
  const bool gradients = anew ? reads.gradients : !voxels_.empty();
  return std::max(2 * have, want) * ((gradients ? kBytesOfVoxel : sizeof(std::int16_t)) + 1);
}

// A block's voxels stand also on the +1 faces of up to seven blocks before it.
void VolumeMemory::mark_stale(std::size_t block) {
  const auto [bx, by, bz] = place(block);
  for (int dz = 0; dz <= std::min(bz, 1); ++dz) {
    for (int dy = 0; dy <= std::min(by, 1); ++dy) {
      for (int dx = 0; dx <= std::min(bx, 1); ++dx) stale_[block_at(bx - dx, by - dy, bz - dz)] = 1;
    }
  }
}

void VolumeMemory::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const auto block = static_cast<std::size_t>(offset / block_bytes_);
    const auto at = static_cast<std::size_t>(offset % block_bytes_);
    const std::size_t length = std::min(bytes.size(), block_bytes_ - at);
    auto& packed = packed_[block];
    if (packed.empty()) {
      packed.resize(block_bytes_);
      ++stored_;
    }
    std::copy_n(bytes.begin(), length, packed.begin() + static_cast<std::ptrdiff_t>(at));
    mark_stale(block);
    bytes = bytes.subspan(length);
    offset += length;
  }
}

void VolumeMemory::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  while (!out.empty()) {
    const auto& packed = packed_[static_cast<std::size_t>(offset / block_bytes_)];
    const auto at = static_cast<std::size_t>(offset % block_bytes_);
    const std::size_t length = std::min(out.size(), block_bytes_ - at);
    if (packed.empty()) {
      std::fill_n(out.begin(), length, std::uint8_t{0});
    } else {
      std::copy_n(packed.begin() + static_cast<std::ptrdiff_t>(at), length, out.begin());
    }
    out = out.subspan(length);
    offset += length;
  }
}

std::optional<VolumeMemory::BitPlace> VolumeMemory::find_bit(std::size_t stored, std::size_t bit) const {
  if (stored_ == 0) return std::nullopt;
  std::size_t block = 0;
  for (std::size_t before = stored % stored_;; ++block) {
    if (packed_[block].empty()) continue;
    if (before == 0) break;
    --before;
  }
  return BitPlace{block, bit % (block_bytes_ * 8)};
}

void VolumeMemory::flip(const BitPlace& place) {
  std::uint8_t& byte = packed_[place.block][place.bit / 8];
  byte = static_cast<std::uint8_t>(byte ^ (1u << place.bit % 8));
  mark_stale(place.block);
}

void VolumeMemory::state(Archive& archive) {
  std::array<int, 3> size = size_;
  archive("size", size);
  if (archive.loads()) {
    for (const int edge : size) {
      const bool fits = edge >= 2 && edge <= static_cast<int>(wire::kMaxVolumeEdge);
      archive.expect(fits || size == std::array<int, 3>{}, "size", "2 to 1024 voxels, or none",
                     static_cast<std::uint64_t>(edge));
    }
    resize(size);
  }
  std::vector<std::size_t> stored;
  for (std::size_t block = 0; block < packed_.size(); ++block) {
    if (!packed_[block].empty()) stored.push_back(block);
  }
  archive.list("stored", stored, packed_.size());
  for (const std::size_t block : stored) {
    archive.expect(block < packed_.size() && packed_[block].empty() == archive.loads(), "stored", "each block once",
                   block);
    archive.bytes("block" + std::to_string(block), packed_[block], block_bytes_, block_bytes_);
  }
  if (!archive.loads()) return;
  stored_ = stored.size();
  std::fill(stale_.begin(), stale_.end(), std::uint8_t{1});
}

bool VolumeMemory::decode_block(std::size_t block, std::span<const DecodedVoxel> codes, bool only_tags) {
  const auto [bx, by, bz] = place(block);
  BlockWords from;
  from.voxels = static_cast<std::size_t>(n_);
  for (int i = 0; i < 8; ++i) {
    const int x = bx + (i & 1), y = by + (i >> 1 & 1), z = bz + (i >> 2);
    const bool inside = x < blocks_[0] && y < blocks_[1] && z < blocks_[2];
    if (inside) from.packed[static_cast<std::size_t>(i)] = packed_[block_at(x, y, z)];
  }
  const std::size_t first = first_[block];
  DecodedBlock to;
  if (!tags_.empty()) to.tags = tags_.data() + first;
  if (!only_tags) {
    if (voxels_.empty()) {
      to.densities = densities_.data() + first;
    } else {
      to.voxels = voxels_.data() + first;
    }
  }
  return emu::decode(from, codes, to);
}

// From densities to voxels everything is decoded anew.
void VolumeMemory::take_form(bool gradients) {
  if (!voxels_.empty() || (!gradients && !densities_.empty())) return;
  densities_ = {};
  tags_ = {};
  std::fill(first_.begin(), first_.end(), std::size_t{0});
  if (gradients) {
    voxels_.resize(voxels_and_faces(), DecodedVoxel{});
  } else {
    densities_.resize(voxels_and_faces() + 1, 0);
  }
  resized_ = true;
}

// Each stored block that is read has its place. Those that have one keep it.
void VolumeMemory::make_places(std::span<const std::uint8_t> leapt_over) {
  const std::size_t voxels = voxels_and_faces(), begin = places();
  std::size_t end = begin;
  for (std::size_t block = 0; block < packed_.size(); ++block) {
    if (packed_[block].empty() || first_[block] != 0 || (!leapt_over.empty() && leapt_over[block] != 0)) continue;
    first_[block] = end;
    end += voxels;
    stale_[block] = 1;
  }
  if (end == begin) return;
  if (voxels_.empty()) {
    densities_.resize(end + 1);
    densities_.back() = 0;
  } else {
    voxels_.resize(end);
  }
  if (!tags_.empty()) tags_.resize(end + kTagsBeyond, 0);
}

void VolumeMemory::decode_blocks(std::span<const std::size_t> which, std::span<const DecodedVoxel> codes,
                                 unsigned threads, bool only_tags) {
  std::atomic<bool> tagged{!tags_.empty()};
  parallel_for(which.size(), threads, [&](std::size_t i) {
    if (decode_block(which[i], codes, only_tags)) tagged = true;
  });
  if (!tagged || !tags_.empty()) return;
  // The first tags of this volume: blocks decoded before them have none.
  tags_.resize(places() + kTagsBeyond, 0);
  decode_blocks(which, codes, threads, true);
}

void VolumeMemory::decode(std::span<const wire::GradientEntry> gradients, bool gradients_changed, unsigned threads,
                          const VolumeReads& reads) {
  take_form(reads.gradients);
  make_places(reads.leapt_over);
  if (gradients_changed && !voxels_.empty()) std::fill(stale_.begin(), stale_.end(), std::uint8_t{1});
  std::vector<std::size_t> stale;
  for (std::size_t block = 0; block < first_.size(); ++block) {
    const bool read = reads.leapt_over.empty() || reads.leapt_over[block] == 0;
    if (first_[block] == 0 || stale_[block] == 0 || !read) continue;
    stale.push_back(block);
    stale_[block] = 0;
  }
  if (stale.empty() && !resized_) return;
  resized_ = false;
  ++decodings_;
  std::vector<DecodedVoxel> codes(wire::kGradientCodes);
  for (std::size_t code = 0; code < codes.size(); ++code) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      codes[code].channel[axis + 1] = static_cast<std::int16_t>(gradients[code][axis] * (1 << kGradientFractionBits));
    }
  }
  decode_blocks(stale, codes, threads);
}

}  // namespace gicube::emu
