#include "firmware/ray_sources/host_rays.h"

#include <algorithm>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "firmware/viewing_rays.h"

namespace gicube::emu {

std::optional<wire::Ray> HostRays::make(std::uint64_t i, RayCounters& counters) {
  wire::Ray& ray = rays_[i];
  if (!frame_.cut_planes.empty() && !enter(ray, frame_.extent, frame_.cut_planes)) return std::nullopt;
  if (frame_.lights()) counters.energy.emitted += energy_units(unpack(ray, frame_), frame_);
  return ray;
}

void HostRays::take(std::uint64_t i, const wire::Ray& ray) {
  if (!come_back_) return;
  wire::Ray& mine = rays_[i];
  const std::uint8_t flags = mine.flags;
  const std::uint16_t interaction = mine.interaction;
  mine = ray;
  mine.flags = flags;
  mine.interaction = interaction;
}

std::size_t HostRays::divide(std::size_t rays) {
  batch_rays_ = std::max<std::size_t>(rays, 1);
  return (rays_.size() + batch_rays_ - 1) / batch_rays_;
}

// Rays are traced where they stand, unless some of them do not enter.
std::unique_ptr<RayBatch> HostRays::make_batch(std::size_t b) {
  auto batch = std::make_unique<RayBatch>();
  const std::size_t begin = b * batch_rays_, count = std::min(batch_rays_, rays_.size() - begin);
  if (frame_.cut_planes.empty()) {
    batch->rays = rays_.subspan(begin, count);
    if (!frame_.lights()) return batch;
    for (const wire::Ray& ray : batch->rays) {
      batch->counters.energy.emitted += energy_units(unpack(ray, frame_), frame_);
    }
    return batch;
  }
  for (std::size_t i = begin; i < begin + count; ++i) {
    if (const auto ray = make(i, batch->counters)) {
      batch->room.push_back(*ray);
      batch->index.push_back(i);
    } else {
      ++batch->returned;
    }
  }
  batch->rays = batch->room;
  return batch;
}

void HostRays::take_batch(RayBatch& batch) {
  for (std::size_t k = 0; k < batch.index.size(); ++k) rays_[batch.index[k]] = batch.rays[k];
}

}  // namespace gicube::emu
