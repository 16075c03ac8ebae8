#include "encode/volume/segmentation_lut.h"

#include <algorithm>
#include <cmath>

#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

std::uint8_t to_shade(double coefficient) {
  return static_cast<std::uint8_t>(std::clamp<long>(std::lround(wire::kShadeOne * coefficient), 0, 255));
}

// Of -1/2 .. 1/2; a half is one step of the word too much.
std::int16_t fine_part(double units) {
  return static_cast<std::int16_t>(std::clamp<long>(std::lround(units * wire::kFineOpacityOne),
                                                    -wire::kFineOpacityOne / 2, wire::kFineOpacityOne / 2 - 1));
}

}  // namespace

std::vector<wire::SegmentationEntry> segmentation_entries(const TransferFunction& function, ValueRange range,
                                                          const Phong& phong, bool wide) {
  wire::SegmentationEntry entry;
  entry.ambient = to_shade(phong.ambient);
  entry.reflect = wire::kShadeOne;
  entry.knee = to_shade(phong.ambient + phong.diffuse);

  std::vector<wire::SegmentationEntry> entries;
  entries.reserve(wire::kDensityMax + 1);
  for (int density = 0; density <= wire::kDensityMax; ++density) {
    const double value = range.low + density * (range.high - range.low) / wire::kDensityMax;
    const Colour colour = function.colour_at(value);
    for (std::size_t c = 0; c < 3; ++c) {
      entry.colour[c] = static_cast<std::uint16_t>(std::lround(colour[c] * wire::kColourOne));
    }
    const double opacity = function.opacity_at(value) * wire::kClassifiedOpacityOne;
    entry.opacity = static_cast<std::uint16_t>(std::lround(opacity));
    if (wide) entry.opacity_fine = fine_part(opacity - entry.opacity);
    entries.push_back(entry);
  }
  return entries;
}

void set_gains(std::vector<wire::SegmentationEntry>& entries, double scattering) {
  constexpr double kMax = 65535;
  for (wire::SegmentationEntry& entry : entries) {
    const double kept = entry.opacity / double{wire::kClassifiedOpacityOne} * (1 - scattering);
    const double gain = kept > 0 ? (1 << wire::kGainFractionBits) / kept : kMax;
    entry.ambient = 0;
    entry.specular = wire::kShadeOne;
    entry.set_gain(static_cast<std::uint32_t>(std::lround(std::min(gain, kMax))));
  }
}

void set_unit_gains(std::vector<wire::SegmentationEntry>& entries) {
  for (wire::SegmentationEntry& entry : entries) {
    entry.ambient = 0;
    entry.specular = wire::kShadeOne;
    entry.set_gain(1 << wire::kGainFractionBits);
  }
}

}  // namespace gicube
