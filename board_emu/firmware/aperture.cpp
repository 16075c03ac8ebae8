#include "aperture.h"

#include <algorithm>

#include "words/record_list.h"

namespace gicube::emu {

namespace {

wire::GradientEntry decode_gradient(std::span<const std::uint8_t> bytes) {
  return wire::to_gradient(wire::load<std::uint32_t>(bytes, 0));
}

bool is(const wire::MemoryRegion* region, const wire::MemoryRegion& which) { return region->base == which.base; }

bool is_irradiance(const wire::MemoryRegion* region) {
  return is(region, wire::kIrradiance) || is(region, wire::kGreenIrradiance) || is(region, wire::kBlueIrradiance);
}

}  // namespace

Aperture::Aperture(int block_voxels, wire::VoxelFormat format, std::size_t irradiance_words,
                   std::uint32_t max_irradiance)
    : segmentation_(wire::kSegmentationEntries, wire::decode<wire::SegmentationEntry>),
      gradients_(wire::kGradientCodes, decode_gradient),
      materials_(wire::kTags, wire::decode<wire::Material>),
      scattering_colours_(wire::kTags, wire::decode<wire::ScatteringColour>),
      accumulators_(block_voxels),
      reflectance_map_(wire::kReflectanceBytes),
      empty_flags_(wire::kEmptyFlags.bytes),
      absent_flags_(wire::kAbsentFlags.bytes),
      dark_flags_(wire::kDarkFlags.bytes),
      volume_(block_voxels, format) {
  for (std::size_t i = 0; i < irradiance_words; ++i) irradiance_.emplace_back(block_voxels, max_irradiance);
}

IrradianceMemory* Aperture::irradiance_of(const wire::MemoryRegion& region) {
  for (std::size_t word = 0; word < irradiance_.size(); ++word) {
    if (is(&region, wire::irradiance_region(word))) return &irradiance_[word];
  }
  return nullptr;
}

std::vector<std::uint8_t>& Aperture::plain_bytes(const wire::MemoryRegion& region) {
  return is(&region, wire::kReflectanceMap) ? reflectance_map_
         : is(&region, wire::kEmptyFlags)   ? empty_flags_
         : is(&region, wire::kAbsentFlags)  ? absent_flags_
                                            : dark_flags_;
}

std::uint64_t Aperture::stored_irradiance_bytes() const {
  std::uint64_t sum = 0;
  for (const IrradianceMemory& each : irradiance_) sum += each.stored_bytes();
  return sum;
}

std::uint64_t Aperture::free_irradiance_bytes(std::uint64_t blocks) const {
  std::uint64_t sum = 0;
  for (const IrradianceMemory& each : irradiance_) sum += each.free_bytes(blocks);
  return sum;
}

void Aperture::clear_irradiance() {
  for (IrradianceMemory& each : irradiance_) each.clear();
}

void Aperture::expect_deposits() {
  for (IrradianceMemory& each : irradiance_) each.expect_deposits();
}

bool Aperture::write(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  const wire::MemoryRegion* region = wire::find_region(address, bytes.size());
  if (region == nullptr || !region->writable) return false;
  const std::uint64_t offset = address - region->base;
  const auto at = static_cast<std::size_t>(offset);
  if (is(region, wire::kVolume)) {
    if (offset + bytes.size() > volume_.bytes()) return false;
    volume_.write(offset, bytes);
    ++volume_writes_;
  } else if (is(region, wire::kColours)) {
    if (!volume_.write_colours(offset, bytes)) return false;
    ++volume_writes_;
  } else if (is_irradiance(region)) {
    IrradianceMemory* const words = irradiance_of(*region);
    if (words == nullptr || offset + bytes.size() > words->bytes()) return false;
    if (offset % 4 != 0 || bytes.size() % 4 != 0) return false;
    words->write(offset, bytes);
    ++volume_writes_;
  } else if (is(region, wire::kMaterials)) {
    materials_.write(at, bytes);
  } else if (is(region, wire::kScatteringColours)) {
    scattering_colours_.write(at, bytes);
  } else if (is(region, wire::kSegmentationLut)) {
    segmentation_.write(at, bytes);
    ++segmentation_writes_;
  } else if (is(region, wire::kGradientLut)) {
    gradients_.write(at, bytes);
    gradients_changed_ = true;
  } else {
    std::ranges::copy(bytes, plain_bytes(*region).begin() + static_cast<std::ptrdiff_t>(at));
  }
  return true;
}

Aperture::Bytes Aperture::bytes_of_write(std::uint64_t address, std::uint64_t length) const {
  const wire::MemoryRegion* region = wire::find_region(address, length);
  if (region == nullptr) return {};
  if (is(region, wire::kVolume)) return {.volume = volume_.bytes_to_write(address - region->base, length)};
  if (is(region, wire::kColours)) {
    return {.volume = volume_.bytes_to_write_colours(address - region->base, length)};
  }
  if (is_irradiance(region)) return {.irradiance = irradiance_[0].bytes_to_write(length)};
  return {};
}

std::uint64_t Aperture::bytes_of_blocks(const std::array<int, 3>& size, int block_voxels,
                                        std::size_t irradiance_words) {
  constexpr std::uint64_t kBytesOfCell = 12;  // maximum data of the functional level for 4^3 voxels (functional/simd)
  std::uint64_t blocks = 1;
  for (const int edge : size) blocks *= static_cast<std::uint64_t>((edge + block_voxels - 1) / block_voxels);
  const auto cells = static_cast<std::uint64_t>(block_voxels / 4);
  return blocks * (VolumeMemory::kBytesOfBlock + irradiance_words * IrradianceMemory::kBytesOfBlock +
                   AccumulatorMemory::kBytesOfBlock + cells * cells * cells * kBytesOfCell);
}

std::optional<std::vector<std::uint8_t>> Aperture::read(std::uint64_t address, std::uint64_t length) {
  const wire::MemoryRegion* region = wire::find_region(address, length);
  if (region == nullptr) return std::nullopt;
  const std::uint64_t offset = address - region->base;
  // Reads a memory that allows only multiples of `unit` bytes.
  const auto read_from = [&](auto& memory, std::uint64_t unit) -> std::optional<std::vector<std::uint8_t>> {
    if (offset + length > memory.bytes() || offset % unit != 0 || length % unit != 0) return std::nullopt;
    std::vector<std::uint8_t> out(static_cast<std::size_t>(length));
    memory.read(offset, out);
    return out;
  };
  if (is(region, wire::kVolume)) return read_from(volume_, 1);
  if (is(region, wire::kColours)) {
    if (offset + length > volume_.colours().bytes()) return std::nullopt;
    std::vector<std::uint8_t> out(static_cast<std::size_t>(length));
    volume_.read_colours(offset, out);
    return out;
  }
  if (is_irradiance(region)) {
    IrradianceMemory* const words = irradiance_of(*region);
    return words != nullptr ? read_from(*words, 4) : std::nullopt;
  }
  if (is(region, wire::kSums)) return read_from(accumulators_, 9);
  if (is(region, wire::kHostDeposits)) return host_deposits_->read(offset, length);
  if (is(region, wire::kHostRayMemory)) return read_records(host_rays_, offset, length);
  const std::span<const std::uint8_t> bytes = is(region, wire::kMaterials)           ? materials_.bytes()
                                              : is(region, wire::kScatteringColours) ? scattering_colours_.bytes()
                                              : is(region, wire::kFramebuffer)       ? std::span(pixels_)
                                              : is(region, wire::kSegmentationLut)   ? segmentation_.bytes()
                                              : is(region, wire::kGradientLut)       ? gradients_.bytes()
                                                                                     : std::span(plain_bytes(*region));
  if (offset + length > bytes.size()) return std::nullopt;
  const auto part = bytes.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
  return std::vector(part.begin(), part.end());
}

void Aperture::state(Archive& archive) {
  archive("segmentation", segmentation_);
  archive("gradients", gradients_);
  archive("materials", materials_);
  archive("scattering_colours", scattering_colours_);
  archive.bytes("reflectance_map", reflectance_map_, reflectance_map_.size(), reflectance_map_.size());
  archive.bytes("empty_flags", empty_flags_, empty_flags_.size(), empty_flags_.size());
  archive.bytes("absent_flags", absent_flags_, absent_flags_.size(), absent_flags_.size());
  archive.bytes("dark_flags", dark_flags_, dark_flags_.size(), dark_flags_.size());
  archive("volume", volume_);
  if (archive.loads()) {
    for (IrradianceMemory& each : irradiance_) each.resize(volume_.size());
    accumulators_.resize(volume_.size());
    gradients_changed_ = true;
  }
  for (std::size_t word = 0; word < irradiance_.size(); ++word) {
    archive(wire::irradiance_region(word).name, irradiance_[word]);
  }
  archive("sums", accumulators_);
  archive("volume_writes", volume_writes_);
  archive("segmentation_writes", segmentation_writes_);
  archive("framebuffer", framebuffer_);
  archive.bytes("pixels", pixels_, 0, wire::kFramebuffer.bytes);
  archive.within("host_deposits", [&] { host_deposits_->state(archive); });
  records_state(archive, "host_rays", host_rays_, wire::kHostRayMemory.bytes);
}

void Aperture::resize_volume(const std::array<int, 3>& size) {
  volume_.resize(size);
  for (IrradianceMemory& each : irradiance_) each.resize(size);
  accumulators_.resize(size);
  ++volume_writes_;
  std::fill(empty_flags_.begin(), empty_flags_.end(), std::uint8_t{0});
  std::fill(absent_flags_.begin(), absent_flags_.end(), std::uint8_t{0});
  std::fill(dark_flags_.begin(), dark_flags_.end(), std::uint8_t{0});
}

void Aperture::drop_blocks() {
  volume_.resize(volume_.size());
  clear_irradiance();
  ++volume_writes_;
}

void Aperture::drop_block(std::size_t block) {
  volume_.drop(block);
  for (IrradianceMemory& each : irradiance_) each.drop(block);
  ++volume_writes_;
}

bool Aperture::any_non_resident() const {
  const auto flags = std::span(absent_flags_).first((volume_.block_count() + 7) / 8);
  return std::ranges::any_of(flags, [](std::uint8_t byte) { return byte != 0; });
}

void Aperture::decode(unsigned threads, const VolumeReads& reads) {
  volume_.decode(gradients_.words(), gradients_changed_, threads, reads);
  gradients_changed_ = false;
}

}  // namespace gicube::emu
