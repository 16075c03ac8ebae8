#include "functional_level.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "dsp/viewing_rays.h"
#include "functional.h"
#include "march.h"
#include "meet.h"

namespace gicube::emu {

namespace {

// Runs `job(i, counters)` for i in [0, count) on `threads` threads and adds their counters up. What one of them throws
// ends all, and is thrown again.
template <typename Counters, typename Job>
Counters spread(std::size_t count, unsigned threads, const Job& job) {
  std::atomic<std::size_t> next{0};
  std::vector<Counters> each(std::max(threads, 1u));
  std::mutex fault_mutex;
  std::exception_ptr fault;
  const auto work = [&](Counters& counters) {
    try {
      for (std::size_t i = next++; i < count; i = next++) job(i, counters);
    } catch (...) {
      next = count;
      const std::lock_guard lock(fault_mutex);
      if (!fault) fault = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < each.size() && t < count; ++t) others.emplace_back([&, t] { work(each[t]); });
    work(each[0]);
  }
  if (fault) std::rethrow_exception(fault);
  Counters sum;
  for (const Counters& counters : each) sum += counters;
  return sum;
}

struct Counts : RayCounters {
  std::uint64_t returned = 0;

  Counts& operator+=(const Counts& other) {
    RayCounters::operator+=(other);
    returned += other.returned;
    return *this;
  }
};

}  // namespace

Rendered render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer, unsigned threads,
                Work& work) {
  constexpr int kSubPixels = 16;
  constexpr int kTile = 16;  // pixels an edge; chosen: the rays of a tile share the voxels that fit a core's cache
  framebuffer.clear(command.width, command.height, command.filter);
  const int samples = command.samples_per_axis, spacing = kSubPixels / samples;

  const auto send = [&](int u, int v, Counts& counts) {
    wire::Ray miss;
    miss.u = static_cast<std::uint16_t>(u);
    miss.v = static_cast<std::uint16_t>(v);
    const Line line = viewing_line(command, static_cast<double>(u) / kSubPixels, static_cast<double>(v) / kSubPixels);
    auto ray = viewing_ray(line, miss.u, miss.v, frame.extent, frame.cut_planes);
    if (!ray) return framebuffer.add(miss);
    ray->lifetime = frame.lifetime;
    if (!integrate(*ray, frame, counts)) return;
    ++counts.returned;
    framebuffer.add(*ray);
  };
  const int across = (command.width + kTile - 1) / kTile, down = (command.height + kTile - 1) / kTile;
  const auto tiles = static_cast<std::size_t>(across * down);
  work.all = static_cast<std::uint32_t>(tiles);
  const auto counts = spread<Counts>(tiles, threads, [&](std::size_t tile, Counts& tile_counts) {
    if (work.cancel) return;
    const int left = static_cast<int>(tile) % across * kTile, top = static_cast<int>(tile) / across * kTile;
    const int right = std::min(left + kTile, int{command.width}), bottom = std::min(top + kTile, int{command.height});
    for (int v = top * kSubPixels + spacing / 2; v < bottom * kSubPixels; v += spacing) {
      for (int u = left * kSubPixels + spacing / 2; u < right * kSubPixels; u += spacing) send(u, v, tile_counts);
    }
    ++work.done;
  });
  const std::uint64_t made = std::uint64_t{command.width} * command.height * static_cast<unsigned>(samples * samples);
  return {made, counts.returned, counts, work.cancel};
}

Rendered illuminate(const LightingRays& rays, const Frame& frame, unsigned threads, Work& work) {
  constexpr std::uint64_t kRun = 4096;  // chosen: neighbours on a face, which share voxels
  const std::uint64_t runs = (rays.count() + kRun - 1) / kRun;
  work.all = static_cast<std::uint32_t>(runs);
  const auto counts = spread<Counts>(static_cast<std::size_t>(runs), threads, [&](std::size_t run, Counts& counters) {
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
                Work& work) {
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
  const auto counts = spread<Counts>(runs, threads, [&](std::size_t run, Counts& run_counts) {
    if (work.cancel) return;
    const std::size_t last = std::min(answers.size(), (run + 1) * kRun);
    for (std::size_t i = run * kRun; i < last; ++i) take(answers[i], run_counts);
    ++work.done;
  });
  return {answers.size(), counts.returned, counts, work.cancel};
}

RayCounters trace(std::span<wire::Ray> rays, const Frame& frame, unsigned threads) {
  constexpr std::size_t kRun = 64;  // rays a thread takes at a time
  const std::size_t runs = (rays.size() + kRun - 1) / kRun;
  return spread<RayCounters>(runs, threads, [&](std::size_t run, RayCounters& counters) {
    const std::size_t end = std::min(rays.size(), (run + 1) * kRun);
    for (std::size_t i = run * kRun; i < end; ++i) {
      if (rays[i].flags == 0 || (!frame.cut_planes.empty() && !enter(rays[i], frame.extent, frame.cut_planes)))
        continue;
      if ((rays[i].flags & wire::kLightingRay) != 0) {
        counters.energy.emitted += energy_units(set_out(rays[i], frame), frame);
      }
      integrate(rays[i], frame, counters);
    }
  });
}

}  // namespace gicube::emu
