// The board's memory as mapped to the host (BAR2): tables, flags, volume, irradiance, framebuffer and others, each at
// its addresses.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "datapath/host_deposits.h"
#include "firmware/framebuffer.h"
#include "gicube/archive.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/material.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/ray.h"
#include "memory/accumulator_memory.h"
#include "memory/irradiance_memory.h"
#include "memory/volume_memory.h"

namespace gicube::emu {

// A LUT: bytes as the host writes them, and decoded words as the pipeline reads them.
template <typename Word, std::size_t WordBytes>
class Table {
 public:
  using Decode = Word (*)(std::span<const std::uint8_t>);

  Table(std::size_t words, Decode decode) : decode_(decode), bytes_(words * WordBytes), words_(words) {
    refresh(0, words);
  }

  void write(std::size_t offset, std::span<const std::uint8_t> bytes) {
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
    refresh(offset / WordBytes, (offset + bytes.size() + WordBytes - 1) / WordBytes);
  }

  std::span<const std::uint8_t> bytes() const { return bytes_; }
  std::span<const Word> words() const { return words_; }
  void state(Archive& archive) {
    archive.bytes("bytes", bytes_, bytes_.size(), bytes_.size());
    if (archive.loads()) refresh(0, words_.size());
  }

 private:
  void refresh(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      words_[i] = decode_(std::span<const std::uint8_t, WordBytes>(bytes_.data() + i * WordBytes, WordBytes));
    }
  }

  Decode decode_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Word> words_;
};

class Aperture {
 public:
  // `irradiance_words`: number per voxel, 1 or 3. `max_irradiance`: value at which a word saturates.
  Aperture(int block_voxels, wire::VoxelFormat format, std::size_t irradiance_words, std::uint32_t max_irradiance);

  // Returns false, and writes nothing, if the range is not in writable memory.
  bool write(std::uint64_t address, std::span<const std::uint8_t> bytes);
  // Returns nothing if the range is not in memory. The framebuffer is as long as its image.
  std::optional<std::vector<std::uint8_t>> read(std::uint64_t address, std::uint64_t length);

  // Host memory in bytes: used for the volume; used for the image; added by a write to the volume, and at most to the
  // irradiance.
  std::uint64_t volume_bytes() const {
    return bytes_of_blocks(volume_.size(), volume_.block_voxels(), irradiance_.size()) + volume_.memory_bytes();
  }
  std::uint64_t image_bytes() const { return framebuffer_.memory_bytes() + pixels_.capacity(); }
  struct Bytes {
    std::uint64_t volume = 0, irradiance = 0;
  };
  Bytes bytes_of_write(std::uint64_t address, std::uint64_t length) const;
  // Host memory in bytes for an empty volume, and for an image while it is resolved.
  static std::uint64_t bytes_of_blocks(const std::array<int, 3>& size, int block_voxels, std::size_t irradiance_words);
  static std::uint64_t bytes_of_image(std::uint64_t pixels) {
    return pixels * (Framebuffer::kBytesPerPixel + 2 * wire::kVoxelBits / 8);
  }

  // Discards the volume and its flags. `size` as in VolumeMemory::resize.
  void resize_volume(const std::array<int, 3>& size);
  // Discard the voxels and the irradiance of all blocks, or of one.
  void drop_blocks();
  void drop_block(std::size_t block);
  // Updates the decoded form of the parts of the volume that `reads` lists.
  void decode(unsigned threads, const VolumeReads& reads);
  // One flag per block: it is empty, is non-resident, has its irradiance at the host.
  std::vector<std::uint8_t> empty() const { return by_block(empty_flags_); }
  std::vector<std::uint8_t> non_resident() const { return by_block(absent_flags_); }
  std::vector<std::uint8_t> irradiance_at_host() const { return by_block(dark_flags_); }
  bool any_non_resident() const;

  const VolumeMemory& volume() const { return volume_; }
  // Simulates an RDRAM error. It is not a write, so caches keep their contents.
  void flip(const VolumeMemory::BitPlace& place) { volume_.flip(place); }
  // Number of writes to the volume. When it changes, cached data of the volume is out of date.
  std::uint64_t volume_writes() const { return volume_writes_; }
  std::uint64_t segmentation_writes() const { return segmentation_writes_; }
  std::span<const wire::SegmentationEntry> segmentation() const { return segmentation_.words(); }
  std::span<const wire::Material> materials() const { return materials_.words(); }
  std::span<const wire::ScatteringColour> scattering_colours() const { return scattering_colours_.words(); }
  // One memory for each irradiance word of a voxel.
  std::span<IrradianceMemory> irradiance() { return irradiance_; }
  std::uint64_t stored_irradiance_bytes() const;
  // Upper limit of the additional bytes if energy reaches at most `blocks` blocks.
  std::uint64_t free_irradiance_bytes(std::uint64_t blocks) const;
  void clear_irradiance();
  void expect_deposits();
  AccumulatorMemory& accumulators() { return accumulators_; }
  const std::uint8_t* reflectance_map() const { return reflectance_map_.data(); }
  Framebuffer& framebuffer() { return framebuffer_; }
  HostDeposits& host_deposits() { return *host_deposits_; }
  // Rays of trace commands, if the volume is out of core.
  std::vector<wire::Ray>& host_rays() { return host_rays_; }
  std::uint64_t host_rays_bytes() const { return host_rays_.capacity() * sizeof(wire::Ray); }
  // Call after rendering: prepares the pixels for the host's reads.
  void resolve_framebuffer(unsigned threads) { pixels_ = framebuffer_.packed(threads); }
  void state(Archive& archive);

 private:
  IrradianceMemory* irradiance_of(const wire::MemoryRegion& region);  // null: not on this card
  std::vector<std::uint8_t>& plain_bytes(const wire::MemoryRegion& region);
  std::vector<std::uint8_t> by_block(const std::vector<std::uint8_t>& flags) const {
    std::vector<std::uint8_t> out(volume_.block_count());
    for (std::size_t block = 0; block < out.size(); ++block) out[block] = flags[block / 8] >> (block % 8) & 1;
    return out;
  }

  Table<wire::SegmentationEntry, wire::kSegmentationEntryBytes> segmentation_;
  Table<wire::GradientEntry, wire::kGradientEntryBytes> gradients_;
  Table<wire::Material, wire::kMaterialBytes> materials_;
  Table<wire::ScatteringColour, wire::kScatteringColourBytes> scattering_colours_;
  std::vector<IrradianceMemory> irradiance_;
  AccumulatorMemory accumulators_;
  bool gradients_changed_ = true;
  std::vector<std::uint8_t> reflectance_map_;
  std::vector<std::uint8_t> empty_flags_;
  std::vector<std::uint8_t> absent_flags_;
  std::vector<std::uint8_t> dark_flags_;
  VolumeMemory volume_;
  std::uint64_t volume_writes_ = 0;
  std::uint64_t segmentation_writes_ = 0;
  Framebuffer framebuffer_;
  std::vector<std::uint8_t> pixels_;
  std::vector<wire::Ray> host_rays_;
  std::unique_ptr<HostDeposits> host_deposits_ = std::make_unique<HostDeposits>();
};

}  // namespace gicube::emu
