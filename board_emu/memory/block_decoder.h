// Converts a block's packed words to decoded voxels and back, with the host's vector instructions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gicube/wire/voxel.h"
#include "words/words.h"

namespace gicube::emu {

// Destination of a block's n^3 words, at their positions among (n+1)^3 voxels.
struct DecodedBlock {
  std::int16_t* densities = nullptr;  // 12.3
  std::uint16_t* codes = nullptr;     // gradient codes and tags (words.h); null: not needed
};

// n: 8, 16, 32 or 64. Returns the OR of the voxels' gradient codes and tags, even if `codes` is null.
std::uint16_t decode(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to);
// decode() without vectors.
std::uint16_t decode_one_by_one(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to);

// Whether packed words, of even number, have irradiance bits, which decode() drops.
bool has_irradiance_bits(std::span<const std::uint8_t> packed);
// Restores the packed words of decoded voxels, if they had no irradiance bits. `codes`: null if all are 0.
void pack(const std::int16_t* densities, const std::uint16_t* codes, std::size_t n, std::span<std::uint8_t> out);

// Colour of a voxel from three bytes per voxel; no bytes: black. `premultiplied`: by the density.
inline DecodedColour decode_colour(std::span<const std::uint8_t> bytes, std::size_t voxel, std::int16_t density,
                                   bool premultiplied) {
  DecodedColour out;
  const int factor = premultiplied ? density : kDecodedColourOne;
  for (std::size_t c = 0; c < wire::kColourBytes; ++c) {
    const int byte = bytes.empty() ? 0 : bytes[wire::kColourBytes * voxel + c];
    out.channel[c] = static_cast<std::int16_t>((byte * factor + 127) / 255);
  }
  out.channel[3] = premultiplied ? density : std::int16_t{0};
  return out;
}

}  // namespace gicube::emu
