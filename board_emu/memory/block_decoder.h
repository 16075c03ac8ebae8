// A block's packed words to decoded voxels, in the host's vectors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "words/words.h"

namespace gicube::emu {

// The words that a block with its +1 faces has: of itself and of its neighbours beyond those faces. Block i is i & 1 along x,
// i >> 1 & 1 along y, i >> 2 along z from it. None: zero.
struct BlockWords {
  std::array<std::span<const std::uint8_t>, 8> packed;
  std::size_t voxels = 0;  // n: 8, 16, 32 or 64
};

// What is made of them, (n+1)^3 of each.
struct DecodedBlock {
  std::int16_t* densities = nullptr;  // 12.3
  std::uint16_t* codes = nullptr;     // gradient codes and tags (words.h); null: not wanted
};

// All bits that the voxels' gradient codes and tags have, whether they are made or not.
std::uint16_t decode(const BlockWords& from, const DecodedBlock& to);
// The same, word by word.
std::uint16_t decode_one_by_one(const BlockWords& from, const DecodedBlock& to);

// The colours of the same blocks, three bytes a voxel. None: black.
struct BlockColours {
  std::array<std::span<const std::uint8_t>, 8> bytes;
};
// Makes (n+1)^3 colours. `premultiplied`: by the densities of `from`.
void decode_colours(const BlockWords& from, const BlockColours& colours, bool premultiplied, DecodedColour* to);

}  // namespace gicube::emu
