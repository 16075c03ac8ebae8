#include "memory/volume_memory.h"

#include <algorithm>
#include <atomic>

#include "gicube/parallel_for.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/voxel.h"
#include "memory/block_decoder.h"

namespace gicube::emu {

VolumeMemory::VolumeMemory(int block_voxels, wire::VoxelFormat format)
    : Blocked(block_voxels),
      format_(format),
      words_(wire::packed36_bytes(voxels_of_block())),
      colours_(wire::kColourBytes * voxels_of_block()),
      gradients_(wire::kGradientCodes) {}

void VolumeMemory::resize(const std::array<int, 3>& size) {
  const std::size_t count = resize_blocks(size);
  words_.resize(count);
  colours_.resize(wire::has_colours(format_) ? count : 0);
  stale_.assign(count, 0);
  first_.assign(count, 0);
  free_ = {};
  densities_ = {};
  codes_ = {};
  has_tags_ = false;
  decoded_colours_ = {};
  resized_ = true;
}

std::uint64_t VolumeMemory::bytes_to_decode(const VolumeReads& reads) const {
  std::uint64_t blocks = densities_.empty() ? 1 : 0;
  for (std::size_t block = 0; block < block_count(); ++block) {
    const bool read = reads.skipped.empty() || reads.skipped[block] == 0;
    if (words_.is_stored(block) && first_[block] == 0 && read) ++blocks;
  }
  blocks -= std::min<std::uint64_t>(blocks, free_.size());
  const bool first_colours = reads.colours && colours_.stored() > 0 && decoded_colours_.empty();
  if (blocks == 0 && !first_colours) return 0;
  // A vector that grows takes twice its size or the requested size, in addition to its old memory.
  const std::uint64_t have = densities_.empty() ? 0 : places(), want = have + blocks * voxels_and_faces();
  const std::uint64_t bytes = blocks == 0 ? 0 : sizeof(std::int16_t) + sizeof(std::uint16_t);
  const bool colours = first_colours || !decoded_colours_.empty();
  return std::max(2 * have, want) * (bytes + (colours ? sizeof(DecodedColour) : 0));
}

// A block's voxels are also on the +1 faces of up to seven blocks before it.
void VolumeMemory::mark_stale(std::size_t block) {
  const auto [bx, by, bz] = place(block);
  for (int dz = 0; dz <= std::min(bz, 1); ++dz) {
    for (int dy = 0; dy <= std::min(by, 1); ++dy) {
      for (int dx = 0; dx <= std::min(bx, 1); ++dx) stale_[block_at(bx - dx, by - dy, bz - dz)] = 1;
    }
  }
}

void VolumeMemory::write(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  words_.write(offset, bytes, packer(), [this](std::size_t block) { mark_stale(block); });
}

bool VolumeMemory::write_colours(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  if (bytes.empty() || offset + bytes.size() > colours_.bytes()) return false;
  const std::uint64_t last = (offset + bytes.size() - 1) / colours_.block_bytes();
  for (std::uint64_t block = offset / colours_.block_bytes(); block <= last; ++block) {
    if (!words_.is_stored(static_cast<std::size_t>(block))) return false;
  }
  colours_.write(offset, bytes, kHere, [this](std::size_t block) { mark_stale(block); });
  return true;
}

void VolumeMemory::drop(std::size_t block) {
  if (!words_.is_stored(block)) return;
  words_.drop(block);
  if (colours_.count() != 0) colours_.drop(block);
  mark_stale(block);
  if (first_[block] != 0) free_.push_back(first_[block]);
  first_[block] = 0;
  resized_ = true;
}

std::optional<VolumeMemory::BitPlace> VolumeMemory::find_bit(std::size_t stored, std::size_t bit) const {
  if (stored_blocks() == 0) return std::nullopt;
  std::size_t block = 0;
  for (std::size_t before = stored % stored_blocks();; ++block) {
    if (!words_.is_stored(block)) continue;
    if (before == 0) break;
    --before;
  }
  const bool has_colours = block < colours_.count() && colours_.is_stored(block);
  return BitPlace{block, bit % (8 * (block_bytes() + (has_colours ? colours_.block_bytes() : 0)))};
}

void VolumeMemory::flip(const BitPlace& place) {
  const std::size_t at = place.bit / 8;
  words_.bring_back(place.block, packer());
  std::uint8_t& byte =
      at < block_bytes() ? words_.byte(place.block, at) : colours_.byte(place.block, at - block_bytes());
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
  words_.state(archive, packer());
  if (wire::has_colours(format_)) archive.within("colours", [&] { colours_.state(archive, kHere); });
  if (archive.loads()) std::fill(stale_.begin(), stale_.end(), std::uint8_t{1});
}

void VolumeMemory::Packer::operator()(std::size_t block, std::span<std::uint8_t> out) const {
  const std::size_t first = of->first_[block];
  pack(of->densities_.data() + first, of->codes_.empty() ? nullptr : of->codes_.data() + first,
       static_cast<std::size_t>(of->n_), out);
}

std::uint16_t VolumeMemory::decode_own(std::size_t block) {
  const std::size_t first = first_[block], n = static_cast<std::size_t>(n_);
  std::uint16_t any = 0;
  if (const auto packed = words_[block]; !packed.empty()) {
    std::uint16_t* const codes = codes_.empty() ? nullptr : codes_.data() + first;
    any = emu::decode(packed, n, {densities_.data() + first, codes});
    if ((codes != nullptr || any == 0) && !has_irradiance_bits(packed)) words_.release(block);
  }
  if (!decoded_colours_.empty()) {
    for (std::size_t voxel = 0; voxel < n * n * n; ++voxel) {
      const std::size_t at = first + voxel % n + edge_ * (voxel / n % n + edge_ * (voxel / (n * n)));
      decoded_colours_[at] = decode_colour(colours_[block], voxel, densities_[at], format_ == wire::VoxelFormat::kRgba);
    }
  }
  return any;
}

std::uint16_t VolumeMemory::copy_row(const std::array<int, 3>& from, std::size_t y, std::size_t z, std::size_t count,
                                     std::size_t at) {
  const bool inside = from[0] < blocks_[0] && from[1] < blocks_[1] && from[2] < blocks_[2];
  const std::size_t block = inside ? block_at(from[0], from[1], from[2]) : 0, n = static_cast<std::size_t>(n_);
  // Words that are here may be newer than their decoded form, if the block is skipped.
  const bool is_packed = inside && !words_[block].empty(), is_decoded = inside && words_.is_elsewhere(block);
  const std::size_t source = is_decoded ? first_[block] + edge_ * (y + edge_ * z) : 0, voxel = n * (y + n * z);
  std::uint16_t any = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::int16_t density = 0;
    std::uint16_t code = 0;
    if (is_decoded) {
      density = densities_[source + i];
      if (!codes_.empty()) code = codes_[source + i];
    } else if (is_packed) {
      const wire::Voxel word = wire::to_voxel(wire::load36(words_[block], voxel + i));
      density = static_cast<std::int16_t>(word.density << kDensityFractionBits);
      code = static_cast<std::uint16_t>(word.gradient | word.tag << kCodeBits);
    }
    any |= code;
    densities_[at + i] = density;
    if (!codes_.empty()) codes_[at + i] = code;
    if (decoded_colours_.empty()) continue;
    const auto bytes = inside ? colours_[block] : std::span<const std::uint8_t>();
    decoded_colours_[at + i] = decode_colour(bytes, voxel + i, density, format_ == wire::VoxelFormat::kRgba);
  }
  return any;
}

std::uint16_t VolumeMemory::decode_faces(std::size_t block) {
  std::uint16_t any = 0;
  const auto [bx, by, bz] = place(block);
  const auto n = static_cast<std::size_t>(n_);
  for (std::size_t z = 0; z <= n; ++z) {
    for (std::size_t y = 0; y <= n; ++y) {
      const int dy = y == n ? 1 : 0, dz = z == n ? 1 : 0;
      const std::size_t row = first_[block] + edge_ * (y + edge_ * z);
      if (dy + dz != 0) any |= copy_row({bx, by + dy, bz + dz}, y % n, z % n, n, row);
      any |= copy_row({bx + 1, by + dy, bz + dz}, y % n, z % n, 1, row + n);
    }
  }
  return any;
}

// Assigns a slot to each stored block that is read. Blocks that have a slot keep it.
void VolumeMemory::make_places(std::span<const std::uint8_t> skipped) {
  const std::size_t voxels = voxels_and_faces();
  if (densities_.empty()) {
    densities_.resize(voxels + 1, 0);
    resized_ = true;
  }
  const std::size_t begin = places();
  std::size_t end = begin;
  for (std::size_t block = 0; block < block_count(); ++block) {
    if (!words_.is_stored(block) || first_[block] != 0 || (!skipped.empty() && skipped[block] != 0)) continue;
    if (free_.empty()) {
      first_[block] = end;
      end += voxels;
    } else {
      first_[block] = free_.back();
      free_.pop_back();
    }
    stale_[block] = 1;
  }
  if (end == begin) return;
  // Blocks of an out-of-core volume arrive little by little, and doubling the size would take too much memory.
  const auto grow = [end, begin](auto& array) {
    if (array.capacity() < end + 1) array.reserve(std::max(end, begin + begin / 4) + 1);
    array.resize(end + 1);
  };
  grow(densities_);
  densities_.back() = 0;
  if (!codes_.empty()) {
    grow(codes_);
    codes_.back() = 0;
  }
  if (!decoded_colours_.empty()) decoded_colours_.resize(end);
}

void VolumeMemory::decode_blocks(std::span<const std::size_t> which, unsigned threads) {
  if (which.empty()) return;
  const bool had_codes = !codes_.empty();
  std::atomic<std::uint32_t> any{0};
  // Codes of blocks in `decoded_next` are left unwritten, so that their pages are allocated when the packed words are
  // freed.
  const auto begin_codes = [&](std::span<const std::size_t> decoded_next) {
    if (any == 0 || !codes_.empty()) return;
    std::vector<bool> is_next(block_count());
    for (const std::size_t block : decoded_next) is_next[block] = !words_[block].empty();
    codes_.resize(places() + 1);
    std::fill_n(codes_.begin(), voxels_and_faces(), std::uint16_t{0});
    codes_.back() = 0;
    for (std::size_t block = 0; block < block_count(); ++block) {
      if (first_[block] == 0 || is_next[block]) continue;
      std::fill_n(codes_.begin() + static_cast<std::ptrdiff_t>(first_[block]), voxels_and_faces(), std::uint16_t{0});
    }
  };
  const auto decode_all = [&] {
    parallel_for(which.size(), threads, [&](std::size_t i) { any |= decode_own(which[i]); });
  };
  // One block mostly shows whether there are codes. Blocks with codes keep their packed words until there is room for
  // codes.
  any |= decode_own(which[which.size() / 2]);
  begin_codes(which);
  decode_all();
  if (any != 0 && codes_.empty()) {
    begin_codes(which);
    decode_all();
  }
  words_.count_held();
  parallel_for(which.size(), threads, [&](std::size_t i) { any |= decode_faces(which[i]); });
  begin_codes({});
  has_tags_ = has_tags_ || any >> kCodeBits != 0;
  if (had_codes == !codes_.empty()) return;
  // These are the first codes: blocks that were decoded before have none on their faces.
  parallel_for(block_count(), threads, [&](std::size_t block) {
    if (first_[block] != 0) decode_faces(block);
  });
}

void VolumeMemory::decode(std::span<const wire::GradientEntry> gradients, bool gradients_changed, unsigned threads,
                          const VolumeReads& reads) {
  make_places(reads.skipped);
  if (reads.colours && decoded_colours_.empty() && colours_.stored() > 0) {
    decoded_colours_.resize(places(), DecodedColour{});
    std::fill(stale_.begin(), stale_.end(), std::uint8_t{1});
  }
  if (gradients_changed) {
    for (std::size_t code = 0; code < gradients_.size(); ++code) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        gradients_[code].channel[axis + 1] =
            static_cast<std::int16_t>(gradients[code][axis] * (1 << kGradientFractionBits));
      }
    }
  }
  std::vector<std::size_t> stale;
  for (std::size_t block = 0; block < first_.size(); ++block) {
    const bool read = reads.skipped.empty() || reads.skipped[block] == 0;
    if (first_[block] == 0 || stale_[block] == 0 || !read) continue;
    stale.push_back(block);
    stale_[block] = 0;
  }
  if (stale.empty() && !resized_) return;
  resized_ = false;
  ++decodings_;
  decode_blocks(stale, threads);
}

}  // namespace gicube::emu
