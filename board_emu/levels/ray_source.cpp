#include "levels/ray_source.h"

#include <algorithm>

namespace gicube::emu {

std::uint64_t RaySource::dsp_cycles(std::uint64_t made, std::uint64_t taken) const {
  if (count() == 0) return 0;
  const DspTask make = making(count() - 1), take = taking(count() - 1);
  const auto begin = [](const DspTask& each, std::uint64_t times) {
    return times == 0 || each.loop == nullptr ? 0 : each.loop->setup();
  };
  return begin(make, made) + (take.loop == make.loop && made > 0 ? 0 : begin(take, taken)) + made * make.cycles() +
         taken * take.cycles();
}

std::size_t RayByRaySource::divide(std::size_t rays) {
  batch_rays_ = std::max<std::size_t>(rays, 1);
  return static_cast<std::size_t>((count() + batch_rays_ - 1) / batch_rays_);
}

std::unique_ptr<RayBatch> RayByRaySource::make_batch(std::size_t b) {
  auto batch = std::make_unique<RayBatch>();
  const std::uint64_t begin = std::uint64_t{b} * batch_rays_, end = std::min(count(), begin + batch_rays_);
  batch->room.reserve(static_cast<std::size_t>(end - begin));
  batch->index.reserve(static_cast<std::size_t>(end - begin));
  for (std::uint64_t i = begin; i < end; ++i) {
    const auto ray = make(i, batch->counters);
    if (!ray) {
      batch->returned += pays_for_misses() ? 1 : 0;
      continue;
    }
    batch->room.push_back(*ray);
    batch->index.push_back(i);
  }
  batch->rays = batch->room;
  return batch;
}

void RayByRaySource::take_batch(RayBatch& batch) {
  for (std::size_t k = 0; k < batch.rays.size(); ++k) take(batch.index[k], batch.rays[k]);
}

}  // namespace gicube::emu
