// A volume of one opacity, and single rays in it.
#pragma once

#include "datapath/interaction.h"
#include "lighting_rig.h"

namespace gicube::emu {

// A volume of one opacity; a step is a voxel long.
struct Fog {
  Fog() : lit({5, 5, 5}, 8, false) { lit.scene.frame.rules = wire::EnergyRules::kAsPrinted; }

  void set(std::uint16_t opacity, std::uint16_t scattering, wire::Bsdf bsdf) {
    lit.scene.segmentation[0].opacity = opacity;
    lit.scene.frame.materials[0].bsdf = bsdf;
    lit.scene.frame.materials[0].scattering = scattering;
    lit.scene.frame.materials[0].flags = wire::kScattersRenderingRays;
  }
  // A ray along x in the middle of a cell: its sample's part reaches from face to face.
  RayState ray(std::uint8_t flags, std::uint16_t number) const {
    wire::Ray packet;
    packet.u = number;
    packet.position = {5u << 13, 2u << 14, 2u << 14};
    packet.direction = {16384, 0, 0};
    packet.flags = flags;
    return unpack(packet, lit.scene.frame);
  }
  Interaction take(RayState& ray) {
    const Frame& frame = lit.scene.frame;
    const BlockGrid grid(*frame.volume);
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(grid.block(ray.position));
    return interact(ray, {at, view, grid.block(ray.position), 9}, frame, counters);
  }

  LitScene lit;
  RayCounters counters;
};

// What one of its samples takes, 24 bits.
inline std::uint32_t alpha_of(const Fog& fog) {
  return (*fog.lit.scene.frame.opacity_correction)(fog.lit.scene.segmentation[0].opacity, 65536);
}

}  // namespace gicube::emu
