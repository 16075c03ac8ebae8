#include "functional/functional_level.h"

#include <algorithm>

#include "functional/backproject.h"
#include "functional/functional.h"
#include "gicube/parallel_for.h"

namespace gicube::emu {

namespace {

// chosen: rays that a thread takes at a time
constexpr std::size_t kVectorRays = 512;
constexpr std::size_t kScalarRays = 64;

struct Counts : RayCounters {
  std::uint64_t made = 0;
  std::uint64_t returned = 0;
  std::uint64_t looking = 0;           // DSP cycles
  const DspLoop* looked_in = nullptr;  // the loop of these cycles

  Counts& operator+=(const Counts& other) {
    RayCounters::operator+=(other);
    made += other.made;
    returned += other.returned;
    looking += other.looking;
    if (other.looked_in != nullptr) looked_in = other.looked_in;
    return *this;
  }
};

// Traces all rays in one batch, which backproject() divides.
Counts backproject_all(RaySource& source, const Frame& frame, unsigned threads) {
  Counts counts;
  for (std::size_t b = source.divide(static_cast<std::size_t>(source.count())); b-- > 0;) {
    const auto batch = source.make_batch(b);
    counts.made += batch->rays.size();
    counts.returned += batch->rays.size() + batch->returned;
    static_cast<RayCounters&>(counts) += batch->counters;
    static_cast<RayCounters&>(counts) += backproject(batch->rays, frame, threads);
    source.take_batch(*batch);
  }
  return counts;
}

Counts trace_all(RaySource& source, const Frame& frame, const SimdTracer* tracer, unsigned threads,
                 Progress& progress) {
  const std::size_t batches = source.divide(tracer != nullptr ? kVectorRays : kScalarRays);
  progress.done = 0;
  progress.all = static_cast<std::uint32_t>(batches);
  return parallel_sum<Counts>(batches, threads, [&](std::size_t b, Counts& counts) {
    if (progress.cancel) return;
    const auto batch = source.make_batch(b);
    counts.made += batch->rays.size();
    static_cast<RayCounters&>(counts) += batch->counters;
    if (tracer != nullptr && frame.gathers()) {
      tracer->trace(batch->rays, frame, counts);
    } else if (frame.plain() && !frame.in_bricks()) {
      for (wire::Ray& ray : batch->rays) integrate(ray, frame, counts);
    } else {  // waiting rays do not return
      const std::vector<bool> ended = integrate_all(batch->rays, frame, counts, tracer, batch->index);
      std::size_t ray = 0;
      batch->keep_if([&](const wire::Ray&) { return ended[ray++]; });
    }
    counts.returned += batch->rays.size() + batch->returned;
    if (frame.lamps) {
      for (const wire::Ray& ray : batch->rays) {
        const DspTask task = source.looking(ray);
        counts.looking += task.cycles();
        if (task.loop != nullptr) counts.looked_in = task.loop;
      }
    }
    source.take_batch(*batch);
    ++progress.done;
  });
}

}  // namespace

RunResult FunctionalLevel::run(RaySource& source, const Frame& frame, Progress& progress) {
  Counts counts;
  if (frame.accumulators != nullptr) {
    counts = backproject_all(source, frame, threads_);
  } else {
    const bool vectors =
        vectors_ && !frame.in_bricks() && tracer_.prepare(source.count(), frame, frame.segmentation_writes, threads_);
    counts = trace_all(source, frame, vectors ? &tracer_ : nullptr, threads_, progress);
  }
  RunResult ran;
  ran.answered = v1::functional;
  ran.made = counts.made;
  ran.rays = counts;
  ran.cancelled = frame.accumulators == nullptr && progress.cancel;
  const std::uint64_t made = source.misses_are_free() ? counts.made : source.count();
  ran.dsp_cycles = source.dsp_cycles(made, counts.returned) + counts.looking + counts.trap_cycles;
  if (counts.looked_in != nullptr) ran.dsp_cycles += counts.looked_in->setup();
  if (!ran.cancelled) rays_ += ran.rays;
  return ran;
}

RayCounters trace(std::span<wire::Ray> rays, const Frame& frame, const SimdTracer* tracer, unsigned threads,
                  std::span<std::int32_t> steps) {
  const std::size_t run_rays = tracer != nullptr ? kVectorRays : kScalarRays;
  const std::size_t runs = (rays.size() + run_rays - 1) / run_rays;
  return parallel_sum<RayCounters>(runs, threads, [&](std::size_t run, RayCounters& counters) {
    const std::size_t begin = run * run_rays, count = std::min(run_rays, rays.size() - begin);
    const auto part = rays.subspan(begin, count);
    const auto their_steps = steps.subspan(begin, count);
    if (tracer != nullptr) return tracer->trace(part, frame, counters, their_steps);
    for (std::size_t i = 0; i < count; ++i) integrate(part[i], frame, counters, &their_steps[i]);
  });
}

}  // namespace gicube::emu
