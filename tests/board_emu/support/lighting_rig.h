// A lit scene without bus and board, for tests: a homogeneous or painted volume, materials, and the functional level's
// lighting pass.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "datapath/ray_step.h"
#include "firmware/lighting_rays.h"
#include "firmware/ray_sources/light_rays.h"
#include "functional/functional.h"
#include "machine_rig.h"

namespace gicube::emu {

class LitScene {
 public:
  // `spacing`: voxel edges. Every voxel has density 0 and tag 0, and no opacity until one is set.
  LitScene(const std::array<int, 3>& size, int block_voxels, bool wide,
           const std::array<double, 3>& spacing = {1, 1, 1})
      : scene(size, block_voxels),
        irradiance(block_voxels, wide ? IrradianceMemory::kWideMost : IrradianceMemory::kPaperMost) {
    irradiance.resize(size);
    scene.fill([](int, int, int) { return wire::Voxel{}; });
    Frame& frame = scene.frame;
    frame.type = wire::RayType::kDeposit;
    frame.wide = wide;
    frame.irradiance = &irradiance;
    frame.lifetime = wire::kLifetimeMax;
    frame.seed = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
      frame.spacing[axis] = static_cast<std::uint32_t>(std::lround(spacing[axis] * wire::kSpacingOne));
  }

  // Optical depth of one unit length of a tag's densities, and what it does to light.
  void medium(double extinction, double scattering, wire::Bsdf bsdf, unsigned tag = 0) {
    const double opacity = -std::expm1(-extinction) * wire::kClassifiedOpacityOne;
    for (std::size_t i = tag << 12; i < (tag + std::size_t{1}) << 12; ++i)
      scene.segmentation[i].opacity = static_cast<std::uint16_t>(std::lround(opacity));
    wire::Material& material = scene.frame.materials[tag];
    material.scattering = static_cast<std::uint16_t>(std::lround(scattering * wire::kScatteringOne));
    material.bsdf = bsdf;
  }

  unsigned energy_bits(const wire::IlluminateCommand& command) const {
    return scene.frame.wide ? 24 : command.albedo == wire::Albedo::kHigh ? 4 : 8;
  }
  LightingRays rays(const wire::IlluminateCommand& command) const {
    return {command, scene.frame.extent, scene.frame.spacing, energy_bits(command), scene.frame.seed};
  }
  // The whole pass; adds to the irradiance.
  RayCounters light(const wire::IlluminateCommand& command, unsigned threads = 2) {
    scene.frame.rules = command.rules;
    scene.set_depths();
    const LightingRays maker = rays(command);
    const v1::DspConfig dsp;
    LightRays source(maker, scene.frame);
    return run_functional(source, scene.frame, threads).rays;
  }
  std::uint32_t irradiance_at(int x, int y, int z) const {
    const int n = scene.volume.block_voxels();
    const auto edge = static_cast<std::size_t>(n) + 1;
    const auto& blocks = scene.volume.blocks();
    const auto block = static_cast<std::size_t>(x / n + blocks[0] * (y / n + blocks[1] * (z / n)));
    const std::uint32_t* words = irradiance.view(block);
    if (words == nullptr) return 0;
    return words[static_cast<std::size_t>(x % n) +
                 edge * (static_cast<std::size_t>(y % n) + edge * static_cast<std::size_t>(z % n))];
  }

  Scene scene;
  IrradianceMemory irradiance;
};

inline wire::IlluminateCommand light_of(wire::LightKind kind, double energy, const std::array<double, 3>& position,
                                        std::uint32_t k, wire::Albedo albedo = wire::Albedo::kLow) {
  wire::IlluminateCommand command;
  command.kind = kind;
  command.albedo = albedo;
  command.energy = energy;
  command.position = position;
  command.rays_per_voxel = command.count = k;
  return command;
}

inline wire::IlluminateCommand sun(double irradiance, const std::array<double, 3>& towards, std::uint32_t k,
                                   wire::Albedo albedo) {
  wire::IlluminateCommand command = light_of(wire::LightKind::kDirectional, irradiance, {}, k, albedo);
  command.u = towards;
  return command;
}

inline double share_of(std::uint64_t part, const EnergyCounters& energy) {
  return static_cast<double>(part) / static_cast<double>(energy.emitted);
}

// What left by the faces z = 0, z = size - 1, and the four others.
inline std::tuple<double, double, double> shares_along_z(const EnergyCounters& energy) {
  const auto& [x_min, x_max, y_min, y_max, z_min, z_max] = energy.escaped_by_face;
  return {share_of(z_min, energy), share_of(z_max, energy), share_of(x_min + x_max + y_min + y_max, energy)};
}

}  // namespace gicube::emu
