// Packets of host rays, and the trace command.
#pragma once

#include <vector>

#include "gicube/wire/ray.h"
#include "scene.h"

namespace gicube::conformance {

// `direction` may have any length except 0.
wire::Ray host_ray(std::uint32_t id, const Vector& position, const Vector& direction);
wire::Ray segment(std::uint32_t id, const Vector& position, const Vector& direction, double length);
Bytes trace_command(wire::TraceHeader header, const std::vector<wire::Ray>& rays);
// Runs the command, and returns the rays that came back.
std::vector<wire::Ray> trace(Host& host, const wire::TraceHeader& header, const std::vector<wire::Ray>& rays);
wire::Ray trace(Host& host, const wire::TraceHeader& header, const wire::Ray& ray);

}  // namespace gicube::conformance
