// The scattering unit: the new direction of a ray after it has interacted with a material [P §2.2, §3.4] [H925-H927].
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/material.h"
#include "gicube/wire/trap.h"
#include "words/words.h"

namespace gicube::emu {

using Direction = std::array<std::int16_t, 3>;  // 1.14, unit length in voxels

inline constexpr std::size_t kRandomDirections = 4096;  // chosen: the random direction LUT's words

// Entry `i` of the random direction LUT: unit vectors in physical space, even over the sphere, in a shuffled order.
const std::array<double, 3>& random_direction(std::size_t i);

// Whether the material is a surface, which scattered rays that run against its gradient leave freely.
constexpr bool reflects(wire::Bsdf bsdf) {
  return bsdf == wire::Bsdf::kSpecular || bsdf == wire::Bsdf::kDullReflection || bsdf == wire::Bsdf::kDiffuse;
}

// The new direction of a ray with direction `direction`. `gradient`: physical, of any length; zero means a surface that
// faces the ray. `spacing`: voxel edges, any unit. `chance`: a draw for this scattering only.
Direction scattered(const wire::Material& material, const Direction& direction, const Point& gradient,
                    const std::array<std::uint32_t, 3>& spacing, std::uint64_t chance);

}  // namespace gicube::emu
