// Makes one tag's quarter of the segmentation LUT from a transfer function; makes the reflectance map, Phong
// illumination by a distant light for all normals [P §3.4].
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/volume.h"
#include "gicube/wire/lut.h"

namespace gicube {

// Throws BadArgument naming the point: "opacities[3].opacity: expected 0..1, got 1.7". The tag must be 0..3, each list
// must have a point, and values must be finite and rise strictly, except that two points may share a value.
void check(const TransferFunction& function, int tag);

// 4096 entries, index = density d, which stands for the value low + d / 4095 (high - low). Colour is rounded to 12 bits
// and opacity to 16: 1 is 65535 exactly, and opacities below 2^-17 are invisible. Shading coefficients are in 1/128.
// Function and coefficients must have passed their checks. `wide`: with 12 further bits of opacity, down to 2^-29.
std::vector<wire::SegmentationEntry> segmentation_entries(const TransferFunction& function, ValueRange range,
                                                          const Phong& phong, bool wide = false);

// Replaces the shading coefficients of entries for samples lit by irradiance: no ambient part, highlights as the
// reflectance map has them, and a gain of 1 / (opacity (1 - scattering)), at most 255.99, because the words hold the
// absorbed share of the light. The gain is that of the colour that absorbs least; the entry's colour is reduced for the
// others.
void set_gains(std::vector<wire::SegmentationEntry>& entries, const std::array<double, 3>& scattering);
// Sets all gains to 1, for words that hold the incident light.
void set_unit_gains(std::vector<wire::SegmentationEntry>& entries);

// Throw BadArgument naming the field and its bound (shading.h).
void check(const Phong& phong);
void check(const Shading& shading);

// Light that a surface reflects in addition to the ambient part: diffuse max(N.L, 0) + specular s(N.L) max(R.V,
// 0)^shininess with R = 2 (N.L) N - L and s = N.L / 0.1 clamped to 0..1. `normal` and `towards_eye` are unit vectors;
// `light` has any length, and the zero vector stands for a light at the eye. All are physical.
double reflected(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye);

// The map's bytes (lut.h): reflected() for each texel's direction, in 1/128, rounded and clamped to 255.
std::vector<std::uint8_t> reflectance_map(const Phong& phong, Vec3 light, Vec3 towards_eye);

}  // namespace gicube
