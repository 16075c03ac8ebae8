#include "upload/host_ray.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "upload/argument.h"

namespace gicube {
namespace {

constexpr std::array<char, 3> kAxisNames{'x', 'y', 'z'};
constexpr double kPositionOne = wire::kVoxel;
constexpr double kDirectionOne = 1 << wire::kDirectionFractionBits;

std::array<double, 3> to_array(Vec3 v) { return {v.x, v.y, v.z}; }

}  // namespace

void check(const HostRay& ray, std::size_t index, Dims dims) {
  const std::array<double, 3> position = to_array(ray.position), direction = to_array(ray.direction);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = dims[axis] - 1;
    if (!(position[axis] >= 0 && position[axis] <= last)) {  // the name is made only when it is needed
      expect_within(fmt::format("rays[{}].position.{}", index, kAxisNames[axis]), position[axis], 0, last);
    }
    if (!std::isfinite(direction[axis])) {
      expect_finite(fmt::format("rays[{}].direction.{}", index, kAxisNames[axis]), direction[axis]);
    }
  }
  if (ray.direction == Vec3{}) throw BadArgument(fmt::format("rays[{}].direction", index), "any length but 0", "0");
}

wire::Ray to_wire(const HostRay& ray) {
  const std::array<double, 3> position = to_array(ray.position), direction = to_array(unit(ray.direction));
  wire::Ray packet;
  packet.set_host_id(ray.id);
  packet.flags = wire::kHostRay;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    packet.position[axis] = static_cast<std::uint32_t>(std::lround(position[axis] * kPositionOne));
    packet.direction[axis] = static_cast<std::int16_t>(std::lround(direction[axis] * kDirectionOne));
  }
  return packet;
}

TracedRay from_wire(const wire::Ray& ray) {
  TracedRay traced;
  traced.id = ray.host_id();
  traced.position = {ray.position[0] / kPositionOne, ray.position[1] / kPositionOne, ray.position[2] / kPositionOne};
  traced.direction = {ray.direction[0] / kDirectionOne, ray.direction[1] / kDirectionOne,
                      ray.direction[2] / kDirectionOne};
  for (std::size_t c = 0; c < 3; ++c) traced.colour[c] = ray.colour[c] / double{wire::kColourOne};
  traced.opacity = ray.opacity / double{wire::kOpacityOne};
  return traced;
}

}  // namespace gicube
