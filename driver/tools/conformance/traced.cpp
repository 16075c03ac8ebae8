#include "traced.h"

#include <cmath>

namespace gicube::conformance {

wire::Ray host_ray(std::uint32_t id, const Vector& position, const Vector& direction) {
  wire::Ray ray;
  const double length = std::hypot(direction[0], direction[1], direction[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    ray.position[i] = static_cast<std::uint32_t>(std::lround(position[i] * wire::kVoxel));
    ray.direction[i] = static_cast<std::int16_t>(std::lround(direction[i] / length * wire::kVoxel));
  }
  ray.flags = wire::kHostRay;
  ray.set_host_id(id);
  return ray;
}

wire::Ray segment(std::uint32_t id, const Vector& position, const Vector& direction, double length) {
  wire::Ray ray = host_ray(id, position, direction);
  ray.set_colour_word(static_cast<std::uint64_t>(std::llround(length * (1 << 16))));
  return ray;
}

Bytes trace_command(wire::TraceHeader header, const std::vector<wire::Ray>& rays) {
  header.count = static_cast<std::uint32_t>(rays.size());
  Bytes command = wire::encoded(header);
  for (const wire::Ray& ray : rays) wire::append(command, ray);
  return command;
}

std::vector<wire::Ray> trace(Host& host, const wire::TraceHeader& header, const std::vector<wire::Ray>& rays) {
  const Bytes result = host.run(trace_command(header, rays));
  check_same("bytes of the rays that came back", result.size(), rays.size() * wire::kRayBytes);
  std::vector<wire::Ray> back;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    back.push_back(wire::decode<wire::Ray>(std::span(result).subspan(i * wire::kRayBytes)));
  }
  return back;
}

wire::Ray trace(Host& host, const wire::TraceHeader& header, const wire::Ray& ray) {
  return trace(host, header, std::vector{ray}).at(0);
}

}  // namespace gicube::conformance
