#include "firmware/viewing_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gicube::emu {

namespace {

constexpr double kUnitsPerVoxel = wire::kVoxel;
constexpr double kPlaneUnits = static_cast<double>(std::int64_t{1} << kPlaneFractionBits);

// Restricts [begin, end] to value + t * slope >= 0.
void cut(Interval& interval, double value, double slope) {
  if (slope > 0) {
    interval.begin = std::max(interval.begin, -value / slope);
  } else if (slope < 0) {
    interval.end = std::min(interval.end, value / -slope);
  } else if (value < 0) {
    interval.end = -1;
  }
}

// Calls use(value, slope) for each kept half space. On the line it is the range with value + t * slope >= 0.
template <typename Use>
void each_half_space(const Line& line, const Point& extent, std::span<const Plane> planes, const Use& use) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    use(line.origin[axis], line.direction[axis]);
    use(extent[axis] / kUnitsPerVoxel - line.origin[axis], -line.direction[axis]);
  }
  for (const Plane& plane : planes) {
    double value = -static_cast<double>(plane.offset) / kPlaneUnits, slope = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double normal = plane.normal[axis] / kUnitsPerVoxel;
      value += normal * line.origin[axis];
      slope += normal * line.direction[axis];
    }
    use(value, slope);
  }
}

// std::round() for values in the range of a long, without a call or a branch.
std::int64_t rounded(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  const double rest = value - static_cast<double>(whole);
  return whole + static_cast<int>(rest >= 0.5) - static_cast<int>(rest <= -0.5);
}

std::uint32_t to_word(double voxels, std::int32_t extent) {
  return static_cast<std::uint32_t>(rounded(std::clamp(voxels * kUnitsPerVoxel, 0.0, static_cast<double>(extent))));
}

}  // namespace

Line viewing_line(const wire::RenderCommand& command, double x, double y) {
  const bool perspective = command.projection == wire::Projection::kPerspective;
  Line line{command.origin, command.forward};
  std::array<double, 3>& moved = perspective ? line.direction : line.origin;
  for (std::size_t axis = 0; axis < 3; ++axis) moved[axis] += x * command.du[axis] + y * command.dv[axis];
  return line;
}

std::optional<Interval> clip(const Line& line, const Point& extent, std::span<const Plane> planes) {
  Interval interval{0, std::numeric_limits<double>::infinity()};
  each_half_space(line, extent, planes, [&interval](double value, double slope) { cut(interval, value, slope); });
  if (interval.begin > interval.end || !std::isfinite(interval.begin)) return std::nullopt;
  return interval;
}

std::optional<Entry> entry(const Line& line, const Point& extent, std::span<const Plane> planes) {
  const std::array<double, 3>& d = line.direction;
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  const auto interval = clip(line, extent, planes);
  if (!interval) return std::nullopt;
  Entry out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.position[axis] = line.origin[axis] + interval->begin * d[axis];
    out.direction[axis] = d[axis] / length;
  }
  int face = 0;
  each_half_space(line, extent, planes, [&](double value, double slope) {
    if (slope > 0 && -value / slope == interval->begin) out.face = face;
    ++face;
  });
  return out;
}

std::optional<wire::Ray> viewing_ray(const Line& line, std::uint16_t u, std::uint16_t v, const Point& extent,
                                     std::span<const Plane> planes) {
  const std::array<double, 3>& d = line.direction;
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
  const auto interval = clip(line, extent, planes);
  if (!interval) return std::nullopt;
  wire::Ray ray;
  ray.u = u;
  ray.v = v;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = to_word(line.origin[axis] + interval->begin * d[axis], extent[axis]);
    ray.direction[axis] = static_cast<std::int16_t>(rounded(d[axis] / length * (1 << wire::kDirectionFractionBits)));
  }
  return ray;
}

bool enter(wire::Ray& ray, const Point& extent, std::span<const Plane> planes) {
  Line line;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    line.origin[axis] = ray.position[axis] / kUnitsPerVoxel;
    line.direction[axis] = ray.direction[axis] / kUnitsPerVoxel;
  }
  const auto interval = clip(line, extent, planes);
  if (!interval) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.position[axis] = to_word(line.origin[axis] + interval->begin * line.direction[axis], extent[axis]);
  }
  return true;
}

}  // namespace gicube::emu
