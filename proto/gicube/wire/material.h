// The material table: one record per tag, which defines how rays scatter [P §2.2]. The segmentation LUT defines colour
// and opacity.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/record.h"

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
  kTrapAtSurface = 1 << 1,  // a trapped ray is not scattered by this material again until it has left it
};

inline constexpr std::uint32_t kScatteringOne = 65535;
inline constexpr int kGlossFractionBits = 12;
inline constexpr std::size_t kMaterialParameters = 32;
inline constexpr std::uint8_t kHostRoutine = 255;

// Decoding does not check the fields. The board refuses a command while one is out of range.
struct Material {
  Bsdf bsdf = Bsdf::kNone;
  std::uint8_t flags = 0;                               // MaterialFlag
  std::uint16_t scattering = 0;                         // Ks, 65535 = 1
  std::uint16_t gloss = 0;                              // beta, unsigned 4.12
  std::uint8_t routine = 0;                             // routine of a trap; 255: the host answers
  std::uint8_t parameter_count = 0;                     // number of valid parameters
  std::array<float, kMaterialParameters> parameters{};  // for the routine

  constexpr void fields(auto&& list) { list(bsdf, flags, scattering, gloss, routine, parameter_count, parameters); }
  friend constexpr bool operator==(const Material&, const Material&) = default;
};
inline constexpr std::size_t kMaterialBytes = bytes_of<Material>();

// With three irradiance words: the share of red, green and blue that a scattering removes, 65535 = all of it.
// `Material::scattering` is that of the colour that is scattered most.
struct ScatteringColour {
  std::array<std::uint16_t, 3> lost{};

  constexpr void fields(auto&& list) { list(lost); }
  friend constexpr bool operator==(const ScatteringColour&, const ScatteringColour&) = default;
};
inline constexpr std::size_t kScatteringColourBytes = bytes_of<ScatteringColour>();

}  // namespace gicube::wire
