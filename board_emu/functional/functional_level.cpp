#include "functional_level.h"

#include <algorithm>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "firmware/viewing_rays.h"
#include "functional.h"
#include "words/parallel_for.h"

namespace gicube::emu {

namespace {

struct Counts : RayCounters {
  std::uint64_t returned = 0;

  Counts& operator+=(const Counts& other) {
    RayCounters::operator+=(other);
    returned += other.returned;
    return *this;
  }
};

}  // namespace

Rendered render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                const SimdTracer* packets, unsigned threads, Progress& work) {
  constexpr int kSubPixels = 16;
  constexpr int kTile = 16;  // pixels an edge; chosen: the rays of a tile share the voxels that fit a core's cache
  framebuffer.clear(command.width, command.height, command.filter);
  const int samples = command.samples_per_axis, spacing = kSubPixels / samples;

  // The ray of a place of the image, unless it misses the volume.
  const auto make = [&](int u, int v, std::vector<wire::Ray>& rays) {
    const Line line = viewing_line(command, static_cast<double>(u) / kSubPixels, static_cast<double>(v) / kSubPixels);
    wire::Ray miss;
    miss.u = static_cast<std::uint16_t>(u);
    miss.v = static_cast<std::uint16_t>(v);
    auto ray = viewing_ray(line, miss.u, miss.v, frame.extent, frame.cut_planes);
    if (!ray) return framebuffer.add_alone(miss);  // tiles share no pixel
    ray->lifetime = frame.lifetime;
    rays.push_back(*ray);
  };
  const int across = (command.width + kTile - 1) / kTile, down = (command.height + kTile - 1) / kTile;
  const auto tiles = static_cast<std::size_t>(across * down);
  work.all = static_cast<std::uint32_t>(tiles);
  const auto counts = parallel_for<Counts>(tiles, threads, [&](std::size_t tile, Counts& tile_counts) {
    if (work.cancel) return;
    const int left = static_cast<int>(tile) % across * kTile, top = static_cast<int>(tile) / across * kTile;
    const int right = std::min(left + kTile, int{command.width}), bottom = std::min(top + kTile, int{command.height});
    std::vector<wire::Ray> rays;
    for (int v = top * kSubPixels + spacing / 2; v < bottom * kSubPixels; v += spacing) {
      for (int u = left * kSubPixels + spacing / 2; u < right * kSubPixels; u += spacing) make(u, v, rays);
    }
    if (packets != nullptr) packets->trace(rays, frame, tile_counts);
    for (wire::Ray& ray : rays) {
      if (packets == nullptr && !integrate(ray, frame, tile_counts)) continue;  // it waits for the host
      ++tile_counts.returned;
      framebuffer.add_alone(ray);
    }
    ++work.done;
  });
  const std::uint64_t made = std::uint64_t{command.width} * command.height * static_cast<unsigned>(samples * samples);
  return {made, counts.returned, counts, work.cancel};
}

Rendered illuminate(const LightingRays& rays, const Frame& frame, unsigned threads, Progress& work) {
  constexpr std::uint64_t kRun = 4096;  // chosen: neighbours on a face, which share voxels
  const std::uint64_t runs = (rays.count() + kRun - 1) / kRun;
  work.all = static_cast<std::uint32_t>(runs);
  const auto counts =
      parallel_for<Counts>(static_cast<std::size_t>(runs), threads, [&](std::size_t run, Counts& counters) {
        if (work.cancel) return;
        const std::uint64_t last = std::min(rays.count(), (run + 1) * kRun);
        for (std::uint64_t i = run * kRun; i < last; ++i) {
          auto ray = rays.make(i);
          if (!ray) continue;
          ray->lifetime = frame.lifetime;
          counters.energy.emitted += energy(ray->colour) >> kEnergyFractionBits;
          ++counters.returned;
          integrate(*ray, frame, counters);
        }
        ++work.done;
      });
  return {counts.returned, counts.returned, counts, work.cancel};
}

Rendered resume(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer, unsigned threads,
                Progress& work) {
  constexpr std::size_t kRun = 64;
  const std::size_t runs = (answers.size() + kRun - 1) / kRun;
  work.all = static_cast<std::uint32_t>(runs);
  const auto take = [&](wire::Ray ray, Counts& counts) {
    const bool light = (ray.flags & wire::kLightingRay) != 0;
    if (!take_answer(ray, frame, counts) && !integrate(ray, frame, counts)) return;  // it waits again
    if (light) return;
    ++counts.returned;
    framebuffer.add(ray);
  };
  const auto counts = parallel_for<Counts>(runs, threads, [&](std::size_t run, Counts& run_counts) {
    if (work.cancel) return;
    const std::size_t last = std::min(answers.size(), (run + 1) * kRun);
    for (std::size_t i = run * kRun; i < last; ++i) take(answers[i], run_counts);
    ++work.done;
  });
  return {answers.size(), counts.returned, counts, work.cancel};
}

namespace {

// Those of the rays that a cut plane leaves something of.
void trace_cut(std::span<wire::Ray> rays, const Frame& frame, const SimdTracer& packets, RayCounters& counters,
               std::span<std::int32_t> steps) {
  std::vector<wire::Ray> entering;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!enter(rays[i], frame.extent, frame.cut_planes)) continue;
    entering.push_back(rays[i]);
    places.push_back(i);
  }
  std::vector<std::int32_t> their_steps(steps.empty() ? 0 : entering.size());
  packets.trace(entering, frame, counters, their_steps);
  for (std::size_t k = 0; k < places.size(); ++k) {
    rays[places[k]] = entering[k];
    if (!steps.empty()) steps[places[k]] = their_steps[k];
  }
}

}  // namespace

RayCounters trace(std::span<wire::Ray> rays, const Frame& frame, const SimdTracer* packets, unsigned threads,
                  std::span<std::int32_t> steps) {
  const std::size_t run_rays = packets != nullptr ? 512 : 64;  // chosen: that a thread takes at a time
  const std::size_t runs = (rays.size() + run_rays - 1) / run_rays;
  return parallel_for<RayCounters>(runs, threads, [&](std::size_t run, RayCounters& counters) {
    const std::size_t begin = run * run_rays, count = std::min(run_rays, rays.size() - begin);
    const auto part = rays.subspan(begin, count);
    const auto their_steps = steps.empty() ? steps : steps.subspan(begin, count);
    if (packets != nullptr && frame.cut_planes.empty()) return packets->trace(part, frame, counters, their_steps);
    if (packets != nullptr) return trace_cut(part, frame, *packets, counters, their_steps);
    for (std::size_t i = 0; i < count; ++i) {
      wire::Ray& ray = part[i];
      if (!frame.cut_planes.empty() && !enter(ray, frame.extent, frame.cut_planes)) continue;
      if ((ray.flags & wire::kLightingRay) != 0) counters.energy.emitted += energy_units(unpack(ray, frame), frame);
      integrate(ray, frame, counters, steps.empty() ? nullptr : &their_steps[i]);
    }
  });
}

}  // namespace gicube::emu
