#include "firmware/ray_sources/resumed_rays.h"

#include "datapath/interaction.h"

namespace gicube::emu {

std::optional<wire::Ray> ResumedRays::make(std::uint64_t i, RayCounters& counters) {
  wire::Ray ray = answers_[i];
  if (!take_answer(ray, frame_, counters)) return ray;
  if (!frame_.lights()) framebuffer_.add(ray);
  return std::nullopt;
}

void ResumedRays::take(std::uint64_t, const wire::Ray& ray) {
  if (!frame_.lights()) framebuffer_.add(ray);
}

}  // namespace gicube::emu
