#include "encode/look_up_tables.h"

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
  expect(!points.empty(), list, "at least one point", "none");
  const auto after = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& point) { return v < point.value; });
  if (after == points.begin()) return {&points.front(), &points.front(), 0};
  if (after == points.end()) return {&points.back(), &points.back(), 0};
  // If two points have one value, upper_bound passed both, so a step takes the second's side.
  const auto before = after - 1;
  return {&*before, &*after, (value - before->value) / (after->value - before->value)};
}

template <typename Point>
void check_values(const std::vector<Point>& points, const char* list) {
  expect(!points.empty(), list, "at least one point", "none");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string field = fmt::format("{}[{}].value", list, i);
    const double value = points[i].value;
    expect_finite(field, value);
    if (i == 0) continue;
    const double previous = points[i - 1].value;
    expect(value >= previous, field, fmt::format("at least {}, the value before it", previous), value);
    const bool is_third = i >= 2 && value == points[i - 2].value;
    expect(!is_third, field, "at most two points at one value", fmt::format("a third at {}", value));
  }
  // Otherwise a weight between two points could be inf / inf.
  const double span = points.back().value - points.front().value;
  expect(std::isfinite(span), list, "values whose span is finite", span);
}

bool is_invisible(const TransferFunction& function) {
  return !function.opacities.empty() &&
         std::ranges::all_of(function.opacities, [](const OpacityPoint& point) { return point.opacity == 0; });
}

std::uint8_t to_shade(double coefficient) {
  return static_cast<std::uint8_t>(std::clamp<long>(std::lround(wire::kShadeOne * coefficient), 0, 255));
}

// Converts -1/2 .. 1/2; 1/2 itself is clamped to the largest value.
std::int16_t fine_part(double units) {
  return static_cast<std::int16_t>(std::clamp<long>(std::lround(units * wire::kFineOpacityOne),
                                                    -wire::kFineOpacityOne / 2, wire::kFineOpacityOne / 2 - 1));
}

constexpr double kShadeMax = 1.99;        // 255/128, the largest shade on the board
constexpr double kSumTolerance = 1e-9;    // 0.99 + 1.0 in doubles
constexpr double kTerminatorWidth = 0.1;  // chosen: with a hard edge at N.L = 0 interpolation errs by up to 0.49

void check_sum(const char* field, double sum) {
  expect(!(sum > kShadeMax + kSumTolerance), field, fmt::format("at most {}", kShadeMax), sum);
}

// The normal that texel (row, column) of a face stands for.
Vec3 texel_normal(int face, int row, int column) {
  const auto coordinate = [](int texel) { return 2.0 * texel / (wire::kReflectanceSize - 1) - 1; };
  const double major = face % 2 == 0 ? 1 : -1, b = coordinate(column), c = coordinate(row);
  switch (face / 2) {
    case 0: return normalise({major, b, c});
    case 1: return normalise({b, major, c});
    default: return normalise({b, c, major});
  }
}

double reflected_unit(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye) {
  const double facing = dot(normal, light);
  if (facing <= 0) return 0;
  const double mirrored = dot(2 * facing * normal - light, towards_eye);
  const double fade = std::min(facing / kTerminatorWidth, 1.0);
  const double highlight = mirrored > 0 ? std::pow(mirrored, phong.shininess) : 0;
  return phong.diffuse * facing + phong.specular * fade * highlight;
}

Vec3 unit_light(Vec3 light, Vec3 towards_eye) { return light == Vec3{} ? towards_eye : unit(light); }

}  // namespace

Colour TransferFunction::colour_at(double value) const {
  if (colours.empty() && is_invisible(*this)) return {};
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
  check_values(function.opacities, "opacities");
  if (!function.colours.empty() || !is_invisible(function)) check_values(function.colours, "colours");
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

void set_gains(std::vector<wire::SegmentationEntry>& entries, const std::array<double, 3>& scattering) {
  constexpr double kMax = 65535;
  for (wire::SegmentationEntry& entry : entries) {
    std::array<double, 3> gains{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double kept = entry.opacity / double{wire::kClassifiedOpacityOne} * (1 - scattering[c]);
      gains[c] = kept > 0 ? std::min((1 << wire::kGainFractionBits) / kept, kMax) : kMax;
    }
    const double most = std::ranges::max(gains);
    entry.ambient = 0;
    entry.specular = wire::kShadeOne;
    entry.set_gain(static_cast<std::uint32_t>(std::lround(most)));
    for (std::size_t c = 0; c < 3; ++c) {
      entry.colour[c] = static_cast<std::uint16_t>(std::lround(entry.colour[c] * gains[c] / most));
    }
  }
}

void set_unit_gains(std::vector<wire::SegmentationEntry>& entries) {
  for (wire::SegmentationEntry& entry : entries) {
    entry.ambient = 0;
    entry.specular = wire::kShadeOne;
    entry.set_gain(1 << wire::kGainFractionBits);
  }
}

void check(const Phong& phong) {
  expect_within("phong.ambient", phong.ambient, 0, kShadeMax);
  expect_within("phong.diffuse", phong.diffuse, 0, kShadeMax);
  expect_within("phong.specular", phong.specular, 0, kShadeMax);
  expect_within("phong.shininess", phong.shininess, 1, 1000);
  check_sum("phong.ambient + phong.diffuse", phong.ambient + phong.diffuse);
  check_sum("phong.diffuse + phong.specular", phong.diffuse + phong.specular);
}

void check(const Shading& shading) {
  check(shading.phong);
  expect_finite("light", shading.light);
}

double reflected(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye) {
  return reflected_unit(phong, normal, unit_light(light, towards_eye), towards_eye);
}

std::vector<std::uint8_t> reflectance_map(const Phong& phong, Vec3 light, Vec3 towards_eye) {
  const Vec3 unit_l = unit_light(light, towards_eye);
  std::vector<std::uint8_t> map;
  map.reserve(wire::kReflectanceBytes);
  for (int face = 0; face < wire::kReflectanceFaces; ++face) {
    for (int row = 0; row < wire::kReflectanceSize; ++row) {
      for (int column = 0; column < wire::kReflectanceSize; ++column) {
        const double shade = reflected_unit(phong, texel_normal(face, row, column), unit_l, towards_eye);
        map.push_back(static_cast<std::uint8_t>(std::clamp<long>(std::lround(wire::kShadeOne * shade), 0, 255)));
      }
    }
  }
  return map;
}

}  // namespace gicube
