#include "aperture.h"

#include <algorithm>

namespace gicube::emu {

namespace {

wire::GradientEntry decode_gradient(std::span<const std::uint8_t> bytes) {
  return wire::to_gradient(wire::load<std::uint32_t>(bytes, 0));
}

bool is(const wire::MemoryRegion* region, const wire::MemoryRegion& which) { return region->base == which.base; }

std::vector<std::uint8_t> slice(std::span<const std::uint8_t> bytes, std::uint64_t offset, std::uint64_t length) {
  const auto part = bytes.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
  return {part.begin(), part.end()};
}

}  // namespace

Aperture::Aperture(int block_voxels, std::uint32_t max_irradiance)
    : segmentation_(wire::kSegmentationEntries, wire::decode<wire::SegmentationEntry>),
      gradients_(wire::kGradientCodes, decode_gradient),
      materials_(wire::kTags, wire::decode<wire::Material>),
      irradiance_(block_voxels, max_irradiance),
      sums_(block_voxels),
      reflectance_map_(wire::kReflectanceBytes),
      empty_flags_(wire::kEmptyFlags.bytes),
      volume_(block_voxels) {}

bool Aperture::write(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  const wire::MemoryRegion* region = wire::find_region(address, bytes.size());
  if (region == nullptr || !region->writable) return false;
  const std::uint64_t offset = address - region->base;
  const auto at = static_cast<std::size_t>(offset);
  if (is(region, wire::kVolume)) {
    if (offset + bytes.size() > volume_.bytes()) return false;
    volume_.write(offset, bytes);
    ++volume_writes_;
  } else if (is(region, wire::kIrradiance)) {
    if (offset + bytes.size() > irradiance_.bytes() || offset % 4 != 0 || bytes.size() % 4 != 0) return false;
    irradiance_.write(offset, bytes);
    ++volume_writes_;
  } else if (is(region, wire::kMaterials)) {
    materials_.write(at, bytes);
  } else if (is(region, wire::kSegmentationLut)) {
    segmentation_.write(at, bytes);
    ++segmentation_writes_;
  } else if (is(region, wire::kGradientLut)) {
    gradients_.write(at, bytes);
    gradients_changed_ = true;
  } else {
    std::vector<std::uint8_t>& target = is(region, wire::kReflectanceMap) ? reflectance_map_ : empty_flags_;
    std::copy(bytes.begin(), bytes.end(), target.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return true;
}

std::optional<std::vector<std::uint8_t>> Aperture::read(std::uint64_t address, std::uint64_t length) const {
  const wire::MemoryRegion* region = wire::find_region(address, length);
  if (region == nullptr) return std::nullopt;
  const std::uint64_t offset = address - region->base;
  if (is(region, wire::kVolume)) {
    if (offset + length > volume_.bytes()) return std::nullopt;
    std::vector<std::uint8_t> out(static_cast<std::size_t>(length));
    volume_.read(offset, out);
    return out;
  }
  if (is(region, wire::kIrradiance)) {
    if (offset + length > irradiance_.bytes() || offset % 4 != 0 || length % 4 != 0) return std::nullopt;
    std::vector<std::uint8_t> out(static_cast<std::size_t>(length));
    irradiance_.read(offset, out);
    return out;
  }
  if (is(region, wire::kSums)) {
    if (offset + length > sums_.bytes() || offset % 9 != 0 || length % 9 != 0) return std::nullopt;
    std::vector<std::uint8_t> out(static_cast<std::size_t>(length));
    sums_.read(offset, out);
    return out;
  }
  if (is(region, wire::kMaterials)) return slice(materials_.bytes(), offset, length);
  if (is(region, wire::kFramebuffer)) {
    if (offset + length > pixels_.size()) return std::nullopt;
    return slice(pixels_, offset, length);
  }
  if (is(region, wire::kSegmentationLut)) return slice(segmentation_.bytes(), offset, length);
  if (is(region, wire::kGradientLut)) return slice(gradients_.bytes(), offset, length);
  return slice(is(region, wire::kReflectanceMap) ? reflectance_map_ : empty_flags_, offset, length);
}

void Aperture::resize_volume(const std::array<int, 3>& size) {
  volume_.resize(size);
  irradiance_.resize(size);
  sums_.resize(size);
  ++volume_writes_;
  std::fill(empty_flags_.begin(), empty_flags_.end(), std::uint8_t{0});
}

void Aperture::decode(unsigned threads, const VolumeReads& reads) {
  volume_.decode(gradients_.words(), gradients_changed_, threads, reads);
  gradients_changed_ = false;
}

}  // namespace gicube::emu
