// Rays of the host as packets, and the commands that carry them.
#pragma once

#include <vector>

#include "gicube/wire/ray.h"
#include "scene.h"

namespace gicube::conformance {

// `direction` has any length but 0.
wire::Ray host_ray(std::uint32_t id, const Vector& position, const Vector& direction);
wire::Ray segment(std::uint32_t id, const Vector& position, const Vector& direction, double length);
Bytes trace_command(wire::TraceHeader header, const std::vector<wire::Ray>& rays);
// The rays as they returned.
std::vector<wire::Ray> trace(Host& host, const wire::TraceHeader& header, const std::vector<wire::Ray>& rays);

}  // namespace gicube::conformance
