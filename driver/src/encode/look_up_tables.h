// Transfer functions, and one tag's quarter of the segmentation LUT that is made of one. The reflectance map: Phong's
// local illumination by a distant light over all normals [P §3.4].
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/volume.h"
#include "gicube/wire/lut.h"

namespace gicube {

// Throws BadArgument naming the point: "opacities[3].opacity: expected 0..1, got 1.7". The tag must be 0..3, both lists
// hold a point, values are finite and rise strictly, but two points (not three) may share one value.
void check(const TransferFunction& function, int tag);

// 4096 entries, index = density d, which stands for the value low + d / 4095 (high - low). Colour is rounded to 12 bits
// and opacity to 16: 1 is 65535 exactly, and what is below 2^-17 is invisible. Shading coefficients come from Phong,
// in 1/128. For a function and coefficients that passed their checks. `wide`: with the opacity's 12 further bits, of
// which 2^-29 is the last that is seen.
std::vector<wire::SegmentationEntry> segmentation_entries(const TransferFunction& function, ValueRange range,
                                                          const Phong& phong, bool wide = false);

// Entries for samples that are lit by irradiance, in place of the shading coefficients: no ambient part, highlights as
// the reflectance map has them, and a gain of 1 / (opacity (1 - scattering)), since that is the share of the light that
// the irradiance words were given; at most 255.99.
// light of a colour that a sample absorbed; colours that absorb more get less of their factor of the entry's colour.
void set_gains(std::vector<wire::SegmentationEntry>& entries, const std::array<double, 3>& scattering);
// Sets all gains to 1, for words that hold the light which falls on a sample.
void set_unit_gains(std::vector<wire::SegmentationEntry>& entries);

// Throw BadArgument naming the field and the bound that shading.h states.
void check(const Phong& phong);
void check(const Shading& shading);

// Light that a surface reflects in addition to the ambient part: diffuse max(N.L, 0) + specular s(N.L) max(R.V,
// 0)^shininess with R = 2 (N.L) N - L and s = N.L / 0.1 clamped to 0..1. `normal` and `towards_eye` are unit vectors;
// `light` has any length, and the zero vector stands for a light at the eye. All are physical.
double reflected(const Phong& phong, Vec3 normal, Vec3 light, Vec3 towards_eye);

// The map's bytes as lut.h has them: reflected() of each texel's direction in 1/128, rounded and held to 255.
std::vector<std::uint8_t> reflectance_map(const Phong& phong, Vec3 light, Vec3 towards_eye);

}  // namespace gicube
