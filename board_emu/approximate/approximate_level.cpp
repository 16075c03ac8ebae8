#include "approximate_level.h"

#include <vector>

#include "datapath/ray_step.h"
#include "firmware/viewing_rays.h"
#include "functional/functional_level.h"

namespace gicube::emu {

namespace {

constexpr std::uint64_t kSubPixels = 16;  // u and v are 12.4 pixels

// Values of a chunk of rays, and the way of each as the turn machine goes it again.
class Chunk {
 public:
  Chunk(const Frame& frame, const SimdTracer* packets, unsigned threads, RayCounters& counters)
      : frame_(frame), packets_(packets), threads_(threads), counters_(counters) {}

  // Ray `i` of the chunk takes part.
  void add(std::size_t i, const wire::Ray& ray) {
    rays_.push_back(ray);
    places_.push_back(i);
  }

  // Traces them and says how far each goes; result(k) is the k-th that was added.
  void trace(std::span<PassRay> out) {
    for (PassRay& ray : out) ray = {};
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      const RayState start = unpack(rays_[k], frame_);
      PassRay& way = out[places_[k]];
      way.position = start.position;
      way.step = frame_.jitter ? drawn_from(start.direction, start.u, start.v) : start.step;
    }
    steps_.assign(rays_.size(), 0);
    counters_ += emu::trace(rays_, frame_, packets_, std::max(1u, threads_ - 1), steps_);
    for (std::size_t k = 0; k < rays_.size(); ++k) {
      out[places_[k]].left = steps_[k];
    }
  }

  std::size_t size() const { return rays_.size(); }
  const wire::Ray& result(std::size_t k) const { return rays_[k]; }
  std::size_t place(std::size_t k) const { return places_[k]; }

 private:
  const Frame& frame_;
  const SimdTracer* packets_;
  unsigned threads_;
  RayCounters& counters_;
  std::vector<wire::Ray> rays_;
  std::vector<std::size_t> places_;
  std::vector<std::int32_t> steps_;
};

class ViewingTurns : public PassRaySource {
 public:
  ViewingTurns(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
               const v1::DspConfig& dsp, const SimdTracer* packets, unsigned threads, RayCounters& counters)
      : command_(command),
        frame_(frame),
        framebuffer_(framebuffer),
        dsp_(dsp),
        packets_(packets),
        threads_(threads),
        counters_(counters),
        across_(std::uint64_t{command.width} * command.samples_per_axis),
        spacing_(kSubPixels / command.samples_per_axis) {}

  std::uint64_t count() const override { return across_ * command_.height * command_.samples_per_axis; }
  std::uint64_t row_end(std::uint64_t i) const override { return (i / across_ + 1) * across_; }
  std::uint32_t make_cycles() const override { return dsp_.viewing_ray_cycles(); }
  std::uint32_t take_cycles() const override { return dsp_.returned_ray_cycles(); }

  void make(std::uint64_t begin, std::span<PassRay> out) override {
    Chunk chunk(frame_, packets_, threads_, counters_);
    for (std::size_t i = 0; i < out.size(); ++i) {
      wire::Ray miss;
      miss.u = static_cast<std::uint16_t>((begin + i) % across_ * spacing_ + spacing_ / 2);
      miss.v = static_cast<std::uint16_t>((begin + i) / across_ * spacing_ + spacing_ / 2);
      const Line line = viewing_line(command_, miss.u / double{kSubPixels}, miss.v / double{kSubPixels});
      auto ray = viewing_ray(line, miss.u, miss.v, frame_.extent, frame_.cut_planes);
      if (!ray) {
        framebuffer_.add(miss);
        continue;
      }
      ray->lifetime = frame_.lifetime;
      chunk.add(i, *ray);
    }
    chunk.trace(out);
    for (std::size_t k = 0; k < chunk.size(); ++k) framebuffer_.add(chunk.result(k));
  }

 private:
  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const v1::DspConfig& dsp_;
  const SimdTracer* packets_;
  unsigned threads_;
  RayCounters& counters_;
  std::uint64_t across_;  // rays in a row
  std::uint64_t spacing_;
};

class GivenTurns : public PassRaySource {
 public:
  GivenTurns(const GivenRayBatch& given, const Frame& frame, const SimdTracer* packets, unsigned threads,
             RayCounters& counters)
      : given_(given), frame_(frame), packets_(packets), threads_(threads), counters_(counters) {}

  std::uint64_t count() const override { return given_.rays.size(); }
  std::uint64_t row_end(std::uint64_t i) const override { return i + 1; }
  std::uint32_t make_cycles() const override { return given_.make_cycles; }
  std::uint32_t take_cycles() const override { return given_.take_cycles; }

  void make(std::uint64_t begin, std::span<PassRay> out) override {
    const auto rays = given_.rays.subspan(static_cast<std::size_t>(begin), out.size());
    Chunk chunk(frame_, packets_, threads_, counters_);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (rays[i].flags == 0 || !enter(rays[i], frame_.extent, frame_.cut_planes)) continue;
      chunk.add(i, rays[i]);
    }
    chunk.trace(out);
    for (std::size_t k = 0; k < chunk.size(); ++k) rays[chunk.place(k)] = chunk.result(k);
  }

 private:
  const GivenRayBatch& given_;
  const Frame& frame_;
  const SimdTracer* packets_;
  unsigned threads_;
  RayCounters& counters_;
};

}  // namespace

RunResult render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                 const v1::DspConfig& dsp, const SimdTracer* packets, unsigned threads, PassMachine& machine,
                 RayCounters& counters, Progress& work) {
  framebuffer.clear(command.width, command.height, command.filter);
  ViewingTurns turns(command, frame, framebuffer, dsp, packets, threads, counters);
  return machine.run(turns, frame, work, threads > 1);
}

RunResult trace(const GivenRayBatch& rays, const Frame& frame, const SimdTracer* packets, unsigned threads,
                PassMachine& machine, RayCounters& counters, Progress& work) {
  GivenTurns turns(rays, frame, packets, threads, counters);
  return machine.run(turns, frame, work, threads > 1);
}

}  // namespace gicube::emu
