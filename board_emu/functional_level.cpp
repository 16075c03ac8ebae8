#include "functional_level.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "dsp/viewing_rays.h"

namespace gicube::emu {

namespace {

// Runs `job(i, counters)` for i in [0, count) on `threads` threads and adds their counters up.
template <typename Counters, typename Job>
Counters spread(std::size_t count, unsigned threads, const Job& job) {
  std::atomic<std::size_t> next{0};
  std::vector<Counters> each(std::max(threads, 1u));
  const auto work = [&](Counters& counters) {
    for (std::size_t i = next++; i < count; i = next++) job(i, counters);
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < each.size() && t < count; ++t) others.emplace_back([&, t] { work(each[t]); });
    work(each[0]);
  }
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
  framebuffer.clear(command.width, command.height, command.filter);
  const int samples = command.samples_per_axis, spacing = kSubPixels / samples;
  work.all = command.height;
  const auto sample_row = [&](int v, Counts& counts) {
    for (int i = 0; i < command.width * samples; ++i) {
      const int u = i * spacing + spacing / 2;
      const Line line = viewing_line(command, static_cast<double>(u) / kSubPixels, static_cast<double>(v) / kSubPixels);
      wire::Ray miss;
      miss.u = static_cast<std::uint16_t>(u);
      miss.v = static_cast<std::uint16_t>(v);
      auto ray = viewing_ray(line, miss.u, miss.v, frame.extent, frame.cut_planes);
      if (ray) {
        integrate(*ray, frame, counts);
        ++counts.returned;
      }
      framebuffer.add(ray.value_or(miss));
    }
  };
  const auto pixel_row = [&](std::size_t row, Counts& counts) {
    if (work.cancel) return;
    for (int j = 0; j < samples; ++j) {
      sample_row(static_cast<int>(row) * kSubPixels + j * spacing + spacing / 2, counts);
    }
    ++work.done;
  };
  const auto counts = spread<Counts>(command.height, threads, pixel_row);
  const std::uint64_t made = std::uint64_t{command.width} * command.height * static_cast<unsigned>(samples * samples);
  return {made, counts.returned, counts, work.cancel};
}

RayCounters trace(std::span<wire::Ray> rays, const Frame& frame, unsigned threads) {
  constexpr std::size_t kRun = 64;  // rays a thread takes at a time
  const std::size_t runs = (rays.size() + kRun - 1) / kRun;
  return spread<RayCounters>(runs, threads, [&](std::size_t run, RayCounters& counters) {
    const std::size_t end = std::min(rays.size(), (run + 1) * kRun);
    for (std::size_t i = run * kRun; i < end; ++i) {
      if (enter(rays[i], frame.extent, frame.cut_planes)) integrate(rays[i], frame, counters);
    }
  });
}

}  // namespace gicube::emu
