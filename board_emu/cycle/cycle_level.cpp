#include "cycle_level.h"

#include "datapath/interaction.h"
#include "firmware/viewing_rays.h"

namespace gicube::emu {

namespace {

constexpr std::uint64_t kSubPixels = 16;  // u and v are 12.4 pixels

class ViewingRays : public RaySource {
 public:
  ViewingRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
              const v1::DspConfig& dsp)
      : command_(command),
        frame_(frame),
        framebuffer_(framebuffer),
        dsp_(dsp),
        across_(std::uint64_t{command.width} * command.samples_per_axis),
        spacing_(kSubPixels / command.samples_per_axis) {}

  std::uint64_t count() const override { return across_ * command_.height * command_.samples_per_axis; }
  std::uint64_t row_end(std::uint64_t i) const override { return (i / across_ + 1) * across_; }
  std::uint32_t make_cycles() const override { return dsp_.viewing_ray_cycles(); }
  std::uint32_t take_cycles() const override { return dsp_.returned_ray_cycles(); }

  std::optional<wire::Ray> make(std::uint64_t i) override {
    const wire::Ray miss = destination(i);
    const Line line = viewing_line(command_, miss.u / double{kSubPixels}, miss.v / double{kSubPixels});
    auto ray = viewing_ray(line, miss.u, miss.v, frame_.extent, frame_.cut_planes);
    if (!ray) {
      framebuffer_.add(miss);
    } else {
      ray->lifetime = frame_.lifetime;
    }
    return ray;
  }

  void take(std::uint64_t i, const RayState& ray_state) override {
    wire::Ray ray = destination(i);
    finish(ray_state, frame_, ray);
    framebuffer_.add(ray);
  }

 private:
  wire::Ray destination(std::uint64_t i) const {
    wire::Ray ray;
    ray.u = static_cast<std::uint16_t>(i % across_ * spacing_ + spacing_ / 2);
    ray.v = static_cast<std::uint16_t>(i / across_ * spacing_ + spacing_ / 2);
    return ray;
  }

  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const v1::DspConfig& dsp_;
  std::uint64_t across_;  // rays in a row
  std::uint64_t spacing_;
};

class RaysThatAreThere : public RaySource {
 public:
  RaysThatAreThere(const GivenRayBatch& given, const Frame& frame) : given_(given), frame_(frame) {}

  std::uint64_t count() const override { return given_.rays.size(); }
  std::uint64_t row_end(std::uint64_t i) const override { return i + 1; }
  std::uint32_t make_cycles() const override { return given_.make_cycles; }
  std::uint32_t take_cycles() const override { return given_.take_cycles; }

  std::optional<wire::Ray> make(std::uint64_t i) override {
    wire::Ray& ray = given_.rays[i];
    if (ray.flags == 0 || !enter(ray, frame_.extent, frame_.cut_planes)) return std::nullopt;
    return ray;
  }
  void take(std::uint64_t i, const RayState& ray_state) override {
    if (given_.come_back) finish(ray_state, frame_, given_.rays[i]);
  }

 private:
  const GivenRayBatch& given_;
  const Frame& frame_;
};

class LightRays : public RaySource {
 public:
  LightRays(const LightingRays& rays, const Frame& frame, const v1::DspConfig& dsp, Lit& lit)
      : rays_(rays), frame_(frame), dsp_(dsp), lit_(lit) {}

  std::uint64_t count() const override { return rays_.count(); }
  std::uint64_t row_end(std::uint64_t i) const override { return i + 1; }  // their energies differ: no runs
  std::uint32_t make_cycles() const override { return dsp_.lighting_ray_cycles(); }
  std::uint32_t take_cycles() const override { return 0; }  // nothing of it is kept
  bool misses_are_free() const override { return true; }

  std::optional<wire::Ray> make(std::uint64_t i) override {
    auto ray = rays_.make(i);
    if (!ray) return ray;
    ray->lifetime = frame_.lifetime;
    lit_.emitted += energy(ray->colour) >> kEnergyFractionBits;
    ++lit_.made;
    return ray;
  }
  void take(std::uint64_t, const RayState&) override {}

 private:
  const LightingRays& rays_;
  const Frame& frame_;
  const v1::DspConfig& dsp_;
  Lit& lit_;
};

class AnsweredRays : public RaySource {
 public:
  AnsweredRays(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer,
               const v1::DspConfig& dsp, RayCounters& counters)
      : answers_(answers), frame_(frame), framebuffer_(framebuffer), dsp_(dsp), counters_(counters) {}

  std::uint64_t count() const override { return answers_.size(); }
  std::uint64_t row_end(std::uint64_t i) const override { return i + 1; }
  std::uint32_t make_cycles() const override { return dsp_.host_ray_cycles() / 2; }
  std::uint32_t take_cycles() const override {
    return !answers_.empty() && is_light(answers_[0]) ? 0 : dsp_.returned_ray_cycles();
  }

  std::optional<wire::Ray> make(std::uint64_t i) override {
    wire::Ray ray = answers_[i];
    if (!take_answer(ray, frame_, counters_)) return ray;
    if (!is_light(ray)) framebuffer_.add(ray);
    return std::nullopt;
  }
  void take(std::uint64_t i, const RayState& ray_state) override {
    wire::Ray ray = answers_[i];
    if (is_light(ray)) return;
    finish(ray_state, frame_, ray);
    framebuffer_.add(ray);
  }

 private:
  static bool is_light(const wire::Ray& ray) { return (ray.flags & wire::kLightingRay) != 0; }

  std::span<const wire::Ray> answers_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const v1::DspConfig& dsp_;
  RayCounters& counters_;
};

}  // namespace

RunResult resume(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer,
                 const v1::DspConfig& dsp, Machine& machine, RayCounters& counters, Progress& work) {
  AnsweredRays rays(answers, frame, framebuffer, dsp, counters);
  return machine.run(rays, frame, work);
}

RunResult illuminate(const LightingRays& rays, const Frame& frame, const v1::DspConfig& dsp, Machine& machine, Lit& lit,
                     Progress& work) {
  LightRays light(rays, frame, dsp, lit);
  return machine.run(light, frame, work);
}

RunResult render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                 const v1::DspConfig& dsp, Machine& machine, Progress& work) {
  framebuffer.clear(command.width, command.height, command.filter);
  ViewingRays rays(command, frame, framebuffer, dsp);
  return machine.run(rays, frame, work);
}

RunResult trace(const GivenRayBatch& rays, const Frame& frame, Machine& machine, Progress& work) {
  RaysThatAreThere given(rays, frame);
  return machine.run(given, frame, work);
}

}  // namespace gicube::emu
