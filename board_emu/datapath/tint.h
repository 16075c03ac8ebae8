// The colour of a sample whose voxels have their own colours (wire::VoxelFormat): a factor of the segmentation LUT's colour.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "datapath/fixed.h"
#include "datapath/resample.h"
#include "datapath/shade.h"
#include "gicube/wire/lut.h"
#include "words/words.h"

namespace gicube::emu {

// The factor from resampled colour words, 4095 = one. Premultiplied words are divided by their alpha, the fourth; alpha 0 gives
// black. The division is IEEE single precision, correctly rounded, hence the same on every machine and SIMD width.
inline Colour12 colour_of_words(const Channels& words, bool premultiplied) {
  Colour12 out{};
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (!premultiplied) {
      out[c] = (words[c] + (1 << (kDensityFractionBits - 1))) >> kDensityFractionBits;
    } else if (words[3] > 0) {
      const float part = static_cast<float>(words[c]) / static_cast<float>(words[3]);
      out[c] = std::min(static_cast<std::int32_t>(std::lrintf(part * wire::kColourOne)),
                        static_cast<std::int32_t>(wire::kColourOne));
    }
  }
  return out;
}

// The entry with its colour multiplied by `factor`.
inline wire::SegmentationEntry tinted(wire::SegmentationEntry entry, const Colour12& factor) {
  for (std::size_t c = 0; c < factor.size(); ++c) {
    const auto product = static_cast<std::uint64_t>(entry.colour[c]) * static_cast<std::uint64_t>(factor[c]);
    entry.colour[c] = static_cast<std::uint16_t>(divide_by_full_scale<12>(product));
  }
  return entry;
}

}  // namespace gicube::emu
