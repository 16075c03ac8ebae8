// The colour of a sample whose voxels have their own colours (wire::VoxelFormat): a factor of the segmentation LUT's
// colour [H708].
#pragma once

#include <cstddef>
#include <cstdint>

#include "datapath/resample.h"
#include "datapath/shade.h"
#include "gicube/wire/lut.h"
#include "words/words.h"

namespace gicube::emu {

inline Colour12 colour_of_words(const Channels& words, bool premultiplied) {
  return factor_of_words<std::int32_t>({words[0], words[1], words[2], words[3]}, premultiplied);
}

// The entry with its colour multiplied by `factor`.
inline wire::SegmentationEntry tinted(wire::SegmentationEntry entry, const Colour12& factor) {
  for (std::size_t c = 0; c < factor.size(); ++c) {
    entry.colour[c] = static_cast<std::uint16_t>(tinted<std::int32_t>(entry.colour[c], factor[c]));
  }
  return entry;
}

}  // namespace gicube::emu
