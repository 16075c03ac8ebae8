// The material table: one record a tag, how rays scatter there [P §2.2]. Colour and opacity are the segmentation LUT's.
//
//   byte  size  field
//      0     1  bsdf         Bsdf
//      1     1  flags        MaterialFlag
//      2     2  scattering   Ks, 65535 = 1
//      4     2  gloss        beta, unsigned 4.12
//      6     1  routine      of a trap; 255: the host answers
//      7     1  parameters   how many of them hold
//      8  4x32  parameter    IEEE single precision, for the routine
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

enum class Bsdf : std::uint8_t {
  kNone = 0,
  kSpecular = 1,
  kDullReflection = 2,
  kDullScattering = 3,
  kIsotropic = 4,
  kDiffuse = 5,
  kTrap = 6,
};

enum MaterialFlag : std::uint8_t {
  kScattersRenderingRays = 1 << 0,
  kTrapAtSurface = 1 << 1,  // a trapped ray passes this material until it has been outside of it
};

inline constexpr std::size_t kMaterialBytes = 136;
inline constexpr std::uint32_t kScatteringOne = 65535;
inline constexpr int kGlossFractionBits = 12;
inline constexpr std::size_t kMaterialParameters = 32;
inline constexpr std::uint8_t kHostRoutine = 255;

struct Material {
  Bsdf bsdf = Bsdf::kNone;
  std::uint8_t flags = 0;
  std::uint16_t scattering = 0;
  std::uint16_t gloss = 0;
  std::uint8_t routine = 0;
  std::uint8_t parameter_count = 0;
  std::array<float, kMaterialParameters> parameters{};

  friend constexpr bool operator==(const Material&, const Material&) = default;
};

inline void encode(const Material& material, std::span<std::uint8_t, kMaterialBytes> out) {
  store(out, 0, static_cast<std::uint8_t>(material.bsdf));
  store(out, 1, material.flags);
  store(out, 2, material.scattering);
  store(out, 4, material.gloss);
  store(out, 6, material.routine);
  store(out, 7, material.parameter_count);
  for (std::size_t i = 0; i < kMaterialParameters; ++i) {
    store(out, 8 + 4 * i, std::bit_cast<std::uint32_t>(material.parameters[i]));
  }
}

// Fields are taken as they come; the board refuses a command while one is out of range.
inline Material decode_material(std::span<const std::uint8_t, kMaterialBytes> in) {
  Material material;
  material.bsdf = static_cast<Bsdf>(load<std::uint8_t>(in, 0));
  material.flags = load<std::uint8_t>(in, 1);
  material.scattering = load<std::uint16_t>(in, 2);
  material.gloss = load<std::uint16_t>(in, 4);
  material.routine = load<std::uint8_t>(in, 6);
  material.parameter_count = load<std::uint8_t>(in, 7);
  for (std::size_t i = 0; i < kMaterialParameters; ++i) {
    material.parameters[i] = std::bit_cast<float>(load<std::uint32_t>(in, 8 + 4 * i));
  }
  return material;
}

}  // namespace gicube::wire
