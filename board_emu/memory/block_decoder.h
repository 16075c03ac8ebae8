// A block's packed words to decoded voxels and back, in the host's vectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gicube/wire/voxel.h"
#include "words/words.h"

namespace gicube::emu {

// What is made of a block's n^3 words, at the places that they have among (n+1)^3 voxels.
struct DecodedBlock {
  std::int16_t* densities = nullptr;  // 12.3
  std::uint16_t* codes = nullptr;     // gradient codes and tags (words.h); null: not wanted
};

// n: 8, 16, 32 or 64. All bits that the voxels' gradient codes and tags have, whether they are made or not.
std::uint16_t decode(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to);
// The same, word by word.
std::uint16_t decode_one_by_one(std::span<const std::uint8_t> packed, std::size_t n, const DecodedBlock& to);

// Whether packed words of an even number have irradiance bits: of those nothing is decoded.
bool has_irradiance_bits(std::span<const std::uint8_t> packed);
// The words that were decoded to these voxels, if they had no irradiance bits. `codes`: null, all 0.
void pack(const std::int16_t* densities, const std::uint16_t* codes, std::size_t n, std::span<std::uint8_t> out);

// The colour of a voxel, of the three bytes that each has; no bytes: black. `premultiplied`: by the density.
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
