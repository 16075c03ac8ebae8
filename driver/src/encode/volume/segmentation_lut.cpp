#include "encode/volume/segmentation_lut.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encode/argument.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube {
namespace {

// The two points around `value` and how far it is from the first to the second, 0..1.
template <typename Point>
struct Segment {
  const Point* from;
  const Point* to;
  double weight;
};

template <typename Point>
Segment<Point> segment_at(const std::vector<Point>& points, double value, const char* list) {
  if (points.empty()) throw BadArgument(list, "at least one point", "none");
  const auto after = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& point) { return v < point.value; });
  if (after == points.begin()) return {&points.front(), &points.front(), 0};
  if (after == points.end()) return {&points.back(), &points.back(), 0};
  // Of two points at one value upper_bound passed both, so a step takes the second's side.
  const auto before = after - 1;
  return {&*before, &*after, (value - before->value) / (after->value - before->value)};
}

template <typename Point>
void check_values(const std::vector<Point>& points, const char* list) {
  if (points.empty()) throw BadArgument(list, "at least one point", "none");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string field = fmt::format("{}[{}].value", list, i);
    expect_finite(field, points[i].value);
    if (i == 0) continue;
    const double previous = points[i - 1].value;
    if (points[i].value < previous) {
      throw BadArgument(field, fmt::format("at least {}, the value before it", previous), number_text(points[i].value));
    }
    if (i >= 2 && points[i].value == points[i - 2].value) {
      throw BadArgument(field, "at most two points at one value", fmt::format("a third at {}", points[i].value));
    }
  }
  // Else a weight between two points could be inf / inf.
  const double span = points.back().value - points.front().value;
  if (!std::isfinite(span)) throw BadArgument(list, "values whose span is finite", number_text(span));
}

std::uint8_t to_shade(double coefficient) {
  return static_cast<std::uint8_t>(std::clamp<long>(std::lround(wire::kShadeOne * coefficient), 0, 255));
}

// Of -1/2 .. 1/2; a half is one step of the word too much.
std::int16_t fine_part(double units) {
  return static_cast<std::int16_t>(std::clamp<long>(std::lround(units * wire::kFineOpacityOne),
                                                    -wire::kFineOpacityOne / 2, wire::kFineOpacityOne / 2 - 1));
}

}  // namespace

Colour TransferFunction::colour_at(double value) const {
  const auto [from, to, weight] = segment_at(colours, value, "colours");
  Colour colour;
  for (std::size_t c = 0; c < colour.size(); ++c) colour[c] = std::lerp(from->colour[c], to->colour[c], weight);
  return colour;
}

double TransferFunction::opacity_at(double value) const {
  const auto [from, to, weight] = segment_at(opacities, value, "opacities");
  return std::lerp(from->opacity, to->opacity, weight);
}

void check(const TransferFunction& function, int tag) {
  expect_within("tag", tag, 0, wire::kTags - 1);
  check_values(function.colours, "colours");
  check_values(function.opacities, "opacities");
  for (std::size_t i = 0; i < function.colours.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      expect_within(fmt::format("colours[{}].colour[{}]", i, c), function.colours[i].colour[c], 0, 1);
    }
  }
  for (std::size_t i = 0; i < function.opacities.size(); ++i) {
    expect_within(fmt::format("opacities[{}].opacity", i), function.opacities[i].opacity, 0, 1);
  }
}

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
