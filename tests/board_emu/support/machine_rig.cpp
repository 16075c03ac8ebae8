#include "machine_rig.h"

#include <cmath>
#include <stdexcept>

#include "config/config.h"
#include "firmware/ray_sources/image_rays.h"

namespace gicube::emu {

v1::BoardConfig config_with(const std::vector<std::string>& assignments) {
  v1::BoardConfig config;
  config.set_fidelity(v1::cycle);
  for (const std::string& assignment : assignments) {
    if (const auto faults = apply_override(config, assignment); !faults.empty()) {
      throw std::invalid_argument(to_string(faults));
    }
  }
  if (const auto faults = check(config); !faults.empty()) throw std::invalid_argument(to_string(faults));
  return resolve(config);
}

Scene::Scene(const std::array<int, 3>& size, int block_voxels, wire::VoxelFormat format)
    : volume(block_voxels, format),
      gradients(wire::kGradientCodes),
      segmentation(wire::kSegmentationEntries),
      reflectance_map(wire::kReflectanceBytes) {
  volume.resize(size);
  for (std::size_t code = 1; code < gradients.size(); ++code) {
    const double angle = static_cast<double>(code) * 2.4, z = 1 - static_cast<double>(code) / 1024;
    const double r = std::sqrt(1 - z * z) * wire::kGradientOne;
    gradients[code] = {static_cast<std::int16_t>(r * std::cos(angle)), static_cast<std::int16_t>(r * std::sin(angle)),
                       static_cast<std::int16_t>(z * wire::kGradientOne)};
  }
  for (std::size_t i = 0; i < reflectance_map.size(); ++i) reflectance_map[i] = static_cast<std::uint8_t>(i * 7 % 200);
  frame.volume = &volume;
  frame.segmentation = segmentation;
  frame.reflectance_map = reflectance_map.data();
  frame.opacity_correction = &opacity_correction;
  frame.step = wire::kStepOne;
  frame.empty.assign(volume.block_count(), 0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    frame.extent[axis] = (size[axis] - 1) * wire::kVoxel;
    frame.spacing[axis] = wire::kSpacingOne;
  }
  volume.decode(gradients, true, 1);  // clear air, until fill()
}

void Scene::set_depths() {
  depths.emplace(segmentation);
  frame.depths = &*depths;
}

RunResult run_functional(RaySource& rays, const Frame& frame, unsigned threads) {
  FunctionalLevel level(threads, false);
  Progress progress;
  return level.run(rays, frame, progress);
}

RunRules runs_of(const v1::BoardConfig& config) { return {config.dsp().run_rays(), config.dsp().run_error()}; }

Picture functional_picture(const Scene& scene, const wire::RenderCommand& view, const RunRules& runs,
                           const Lamps& lamps) {
  Picture picture;
  Framebuffer framebuffer;
  ImageRays rays(view, scene.frame, framebuffer, runs, lamps);
  picture.rays = run_functional(rays, scene.frame).rays;
  picture.pixels = framebuffer.packed();
  return picture;
}

Picture cycle_picture(const Scene& scene, const wire::RenderCommand& view, Machine& machine, const RunRules& runs,
                      const Lamps& lamps) {
  Picture picture;
  Framebuffer framebuffer;
  Progress progress;
  const RayCounters before = ray_counters(machine);
  ImageRays rays(view, scene.frame, framebuffer, runs, lamps);
  picture.ran = machine.run(rays, scene.frame, progress);
  picture.pixels = framebuffer.packed();
  picture.rays = ray_counters(machine) - before;
  return picture;
}

Picture ahead_picture(const Scene& scene, const wire::RenderCommand& view, Machine& machine, const RunRules& runs,
                      bool saves) {
  Picture picture;
  Framebuffer framebuffer;
  Progress progress;
  const RayCounters before = ray_counters(machine);
  ImageRays rays(view, scene.frame, framebuffer, runs);
  const RayRange all{0, rays.count()};
  std::optional<FunctionalTrace> values;
  OpacityCorrection correction;
  SimdTracer vectors(correction);
  const bool lit = scene.frame.lit_by_irradiance && scene.frame.gathers() && !scene.frame.in_bricks() &&
                   vectors.prepare(rays.count(), scene.frame, scene.frame.segmentation_writes, 1);
  const SimdTracer* const tracer = lit ? &vectors : nullptr;
  if (FunctionalTrace::covers(scene.frame, tracer)) values.emplace(rays, all, scene.frame, tracer, 1);
  if (saves) {
    progress.may_count = [&machine, at = machine.now()] {
      if (machine.now() - at > 3 * 4096) return;  // early in the run
      std::vector<std::uint64_t> numbers;
      NumbersArchive archive(false, numbers);
      archive.set_in_run(true);
      machine.state(archive);
    };
  }
  picture.ran = machine.run(rays, scene.frame, progress, all, values ? &*values : nullptr);
  picture.pixels = framebuffer.packed();
  picture.rays = ray_counters(machine) - before;
  return picture;
}

RayCounters trace_functional(std::span<wire::Ray> rays, const Frame& frame) {
  HostRays source(rays, frame, true);
  return run_functional(source, frame).rays;
}

RunResult trace_cycle(std::span<wire::Ray> rays, const Frame& frame, Machine& machine) {
  HostRays source(rays, frame, true);
  Progress progress;
  return machine.run(source, frame, progress);
}

}  // namespace gicube::emu
