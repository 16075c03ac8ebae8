#include "command_fault.h"

#include <algorithm>
#include <cmath>

#include "datapath/advance.h"
#include "firmware/framebuffer.h"

namespace gicube::emu {

CommandResult refuse(const std::string& text) {
  return {.error = wire::ErrorCode::kBadValue, .payload = std::vector<std::uint8_t>(text.begin(), text.end())};
}

std::string expected(const std::string& field, const std::string& range, std::uint64_t got) {
  return field + ": expected " + range + ", got " + std::to_string(got);
}

std::optional<std::string> fault(const wire::RenderCommand& command, std::uint64_t framebuffer_mb) {
  if (command.width < 1 || command.width > wire::kMaxImageSize) return expected("width", "1..4095", command.width);
  if (command.height < 1 || command.height > wire::kMaxImageSize) return expected("height", "1..4095", command.height);
  if (command.projection > wire::Projection::kPerspective) {
    return expected("projection", "0 or 1", static_cast<std::uint64_t>(command.projection));
  }
  const int samples = command.samples_per_axis;
  if (samples != 1 && samples != 2 && samples != 4) {
    return expected("samples_per_axis", "1, 2 or 4", command.samples_per_axis);
  }
  if (command.filter > wire::Filter::kTent)
    return expected("filter", "0 or 1", static_cast<std::uint64_t>(command.filter));
  for (const auto* vector : {&command.origin, &command.forward, &command.du, &command.dv}) {
    if (!std::all_of(vector->begin(), vector->end(), [](double x) { return std::isfinite(x); })) {
      return "origin, forward, du, dv: expected finite numbers";
    }
  }
  const std::uint64_t bytes = std::uint64_t{command.width} * command.height * Framebuffer::kBytesPerPixel;
  if (bytes > framebuffer_mb * 1'000'000) {
    return expected("width x height", "an image whose sums fit dsp.framebuffer_mb = " + std::to_string(framebuffer_mb),
                    bytes) +
           " bytes";
  }
  return std::nullopt;
}

std::optional<std::string> fault(const wire::Ray& ray, const Point& extent) {
  const Point position{static_cast<std::int32_t>(ray.position[0]), static_cast<std::int32_t>(ray.position[1]),
                       static_cast<std::int32_t>(ray.position[2])};
  if (!inside(position, extent)) return "position: expected a point of the volume";
  const Point d{ray.direction[0], ray.direction[1], ray.direction[2]};
  const double length = std::sqrt(static_cast<double>(dot(d, d))) / (1 << wire::kDirectionFractionBits);
  // A shorter direction could round to a step of nothing.
  if (!(std::abs(length - 1) < 0.01)) return "direction: expected a unit vector to within 1%";
  return std::nullopt;
}

}  // namespace gicube::emu
