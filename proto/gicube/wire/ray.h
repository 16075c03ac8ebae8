// The 256-bit ray packet, used on the host bus, the ray bus, in the queues and on the links. README.md defines its
// bits.
//
// Field list: [P §2.1 and Figure 2]. The widths are chosen, because those of the figure are lost
// (docs/reference/hardware.md).
#pragma once

#include <array>
#include <cstdint>

#include "gicube/wire/record.h"

namespace gicube::wire {

inline constexpr int kPositionFractionBits = 14;
inline constexpr std::int32_t kVoxel = 1 << kPositionFractionBits;  // one voxel in position units
inline constexpr std::uint32_t kPositionMax = (1u << 24) - 1;
inline constexpr int kDirectionFractionBits = 14;
inline constexpr std::uint32_t kColourOne = 4095;
inline constexpr std::uint32_t kOpacityOne = (1u << 24) - 1;
inline constexpr std::uint32_t kLifetimeMax = 1023;

enum RayFlag : std::uint8_t {
  kLightingRay = 1 << 0,  // otherwise a rendering ray
  kHighAlbedo = 1 << 1,
  kIrradianceCarrier = 1 << 2,
  kTrapped = 1 << 3,     // waits for a scattering routine on the DSP
  kOverflowed = 1 << 4,  // came back because its queue was full
  kHostRay = 1 << 5,     // made by the host: (v, u) is its id, and it returns over the bus
};

struct Ray {
  std::uint16_t u = 0, v = 0;               // image column and row, unsigned 12.4 pixels; host ray: id
  std::array<std::uint32_t, 3> position{};  // unsigned 10.14 voxels
  std::array<std::int16_t, 3> direction{};  // signed 1.14, unit length in voxels
  std::array<std::uint16_t, 3> colour{};    // premultiplied red green blue; lighting ray: energy
  std::uint32_t opacity = 0;
  std::uint16_t contribution = kColourOne;  // the maximum that the ray can still add to the image, 4095 = 1
  std::uint16_t lifetime = kLifetimeMax;    // remaining path segments; decremented at each scattering
  std::uint8_t generation = 0;              // scatterings so far, saturating
  std::uint16_t interaction = 0;            // opacity at which a scattered ray next interacts, 4095 = 1
  std::uint8_t flags = 0;                   // RayFlag

  constexpr void bits(auto&& list) {
    list(16, u, v);
    list(24, position);
    list(16, direction);
    list(12, colour);
    list(24, opacity);
    list(12, contribution);
    list(10, lifetime);
    list(4, generation);
    list(12, interaction);
    list(6, flags);
  }
  constexpr std::uint32_t host_id() const { return std::uint32_t{v} << 16 | u; }
  constexpr void set_host_id(std::uint32_t id) {
    u = static_cast<std::uint16_t>(id);
    v = static_cast<std::uint16_t>(id >> 16);
  }
  // The colour's bits as one word: a lighting ray's energy or a segment's length (command.h).
  constexpr std::uint64_t colour_word() const {
    return colour[0] | std::uint64_t{colour[1]} << 12 | std::uint64_t{colour[2]} << 24;
  }
  constexpr void set_colour_word(std::uint64_t word) {
    for (std::size_t i = 0; i < 3; ++i) colour[i] = static_cast<std::uint16_t>(word >> (12 * i) & 0xFFF);
  }
  friend constexpr bool operator==(const Ray&, const Ray&) = default;
};
// [P §3.6]. Every bit pattern is a ray. The DSP checks whether it is valid (unit direction, position in the volume).
inline constexpr std::size_t kRayBytes = bytes_of<Ray>();
inline constexpr std::uint32_t kRayBits = 8 * kRayBytes;

// Maximum deviation of a ray's position from its line on each axis, in voxels, on the paper's datapath, after `voxels`
// voxels in steps of `step` (16.16). A position is the start plus a multiple of one rounded step. Rounding the
// direction adds at most half a unit per voxel. Rounding the step adds half a unit per step, or nothing if steps are
// whole voxels. On the wide datapath steps are not rounded and positions only once: the limit there is voxels / 2^15
// plus half a unit.
constexpr double max_drift(double voxels, std::uint32_t step) {
  constexpr double kOne = 1 << 16;
  const double by_steps = step % (1u << 16) == 0 ? 0 : kOne / step;
  return voxels * (1 + by_steps) / (2 * kVoxel);
}

// Rounds x, 0..2^30, to the nearest integer without a library call. Used for the words of positions and directions.
constexpr std::uint32_t to_nearest(double x) { return (static_cast<std::uint32_t>(2 * x) + 1) / 2; }

}  // namespace gicube::wire
