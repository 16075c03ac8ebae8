#include "firmware/ray_sources/light_rays.h"

#include "datapath/ray_step.h"

namespace gicube::emu {

std::optional<wire::Ray> LightRays::make(std::uint64_t i, RayCounters& counters) {
  auto ray = rays_.make(i);
  if (!ray) return ray;
  ray->lifetime = frame_.lifetime;
  counters.energy.emitted += ray->colour_word() >> kEnergyFractionBits;
  return ray;
}

}  // namespace gicube::emu
