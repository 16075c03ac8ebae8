// The 256-bit ray packet that travels over the host bus, the ray bus, the queues and the links.
//
//   bit    width  field         unit
//     0      16   u             image column, unsigned 12.4 pixels  (host ray: low half of its id)
//    16      16   v             image row, unsigned 12.4 pixels     (host ray: high half of its id)
//    32   3 x 24  position      unsigned 10.14 voxels, x y z
//   104   3 x 16  direction     signed 1.14, unit length in voxels, x y z
//   152   3 x 12  colour        premultiplied red green blue, 4095 = 1  (lighting ray: its energy)
//   188      24   opacity       2^24 - 1 = 1
//   212      12   contribution  what the ray can still add to the image, 4095 = 1
//   224      10   lifetime      flights that are left; counted down at each scattering
//   234       4   generation    scatterings so far, saturating
//   238      12   interaction   opacity at which a scattered ray next interacts, 4095 = 1
//   250       6   flags         RayFlag
//
// Field list: [P §2.1 and Figure 2]; widths: the figure's are lost, so chosen (docs/reference/hardware.md).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

inline constexpr std::size_t kRayBytes = 32;  // [P §3.6]
inline constexpr int kPositionFractionBits = 14;
inline constexpr std::int32_t kVoxel = 1 << kPositionFractionBits;  // one voxel in position units
inline constexpr std::uint32_t kPositionMax = (1u << 24) - 1;
inline constexpr int kDirectionFractionBits = 14;
inline constexpr std::uint32_t kColourOne = 4095;
inline constexpr std::uint32_t kOpacityOne = (1u << 24) - 1;
inline constexpr std::uint32_t kLifetimeMax = 1023;

enum RayFlag : std::uint8_t {
  kLightingRay = 1 << 0,  // else a rendering ray
  kHighAlbedo = 1 << 1,
  kIrradianceCarrier = 1 << 2,
  kTrapped = 1 << 3,     // waits for a scattering routine on the DSP
  kOverflowed = 1 << 4,  // came back because its queue was full
  kHostRay = 1 << 5,     // made by the host: (v, u) is its id and it returns over the bus
};

struct Ray {
  std::uint16_t u = 0;
  std::uint16_t v = 0;
  std::array<std::uint32_t, 3> position{};
  std::array<std::int16_t, 3> direction{};
  std::array<std::uint16_t, 3> colour{};
  std::uint32_t opacity = 0;
  std::uint16_t contribution = kColourOne;
  std::uint16_t lifetime = kLifetimeMax;
  std::uint8_t generation = 0;
  std::uint16_t interaction = 0;
  std::uint8_t flags = 0;

  constexpr std::uint32_t host_id() const { return std::uint32_t{v} << 16 | u; }
  constexpr void set_host_id(std::uint32_t id) {
    u = static_cast<std::uint16_t>(id);
    v = static_cast<std::uint16_t>(id >> 16);
  }
  // The colour's bits as one word: a lighting ray's energy, a segment's length (command.h).
  constexpr std::uint64_t colour_word() const {
    return colour[0] | std::uint64_t{colour[1]} << 12 | std::uint64_t{colour[2]} << 24;
  }
  constexpr void set_colour_word(std::uint64_t word) {
    for (std::size_t i = 0; i < 3; ++i) colour[i] = static_cast<std::uint16_t>(word >> (12 * i) & 0xFFF);
  }
  friend constexpr bool operator==(const Ray&, const Ray&) = default;
};

// The nearest whole number to x, 0..2^30: what rounds a position or a direction into its word, without a library call.
constexpr std::uint32_t to_nearest(double x) { return (static_cast<std::uint32_t>(2 * x) + 1) / 2; }

inline void encode(const Ray& ray, std::span<std::uint8_t, kRayBytes> out) {
  BitRecord<4> bits;
  bits.put(0, 16, ray.u);
  bits.put(16, 16, ray.v);
  for (unsigned axis = 0; axis < 3; ++axis) {
    bits.put(32 + 24 * axis, 24, ray.position[axis]);
    bits.put(104 + 16 * axis, 16, static_cast<std::uint16_t>(ray.direction[axis]));
    bits.put(152 + 12 * axis, 12, ray.colour[axis]);
  }
  bits.put(188, 24, ray.opacity);
  bits.put(212, 12, ray.contribution);
  bits.put(224, 10, ray.lifetime);
  bits.put(234, 4, ray.generation);
  bits.put(238, 12, ray.interaction);
  bits.put(250, 6, ray.flags);
  for (std::size_t word = 0; word < 4; ++word) store(out, 8 * word, bits.words[word]);
}

// Every bit pattern is a ray; whether it makes sense (unit direction, position in the volume) is the DSP's to check.
inline Ray decode_ray(std::span<const std::uint8_t, kRayBytes> in) {
  BitRecord<4> bits;
  for (std::size_t word = 0; word < 4; ++word) bits.words[word] = load<std::uint64_t>(in, 8 * word);
  Ray ray;
  ray.u = static_cast<std::uint16_t>(bits.get(0, 16));
  ray.v = static_cast<std::uint16_t>(bits.get(16, 16));
  for (unsigned axis = 0; axis < 3; ++axis) {
    ray.position[axis] = bits.get(32 + 24 * axis, 24);
    ray.direction[axis] = static_cast<std::int16_t>(bits.get(104 + 16 * axis, 16));
    ray.colour[axis] = static_cast<std::uint16_t>(bits.get(152 + 12 * axis, 12));
  }
  ray.opacity = bits.get(188, 24);
  ray.contribution = static_cast<std::uint16_t>(bits.get(212, 12));
  ray.lifetime = static_cast<std::uint16_t>(bits.get(224, 10));
  ray.generation = static_cast<std::uint8_t>(bits.get(234, 4));
  ray.interaction = static_cast<std::uint16_t>(bits.get(238, 12));
  ray.flags = static_cast<std::uint8_t>(bits.get(250, 6));
  return ray;
}

}  // namespace gicube::wire
