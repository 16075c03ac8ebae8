// Classification: the segmentation LUT gives a sample its colour, opacity and shading coefficients [P §3.4].
#pragma once

#include <cstddef>
#include <cstdint>

#include "gicube/wire/lut.h"
#include "words/words.h"

namespace gicube::emu {

// The LUT's index of an interpolated density (12.3) of material `tag`: the density rounded to 12 bits.
constexpr std::size_t segmentation_index(int density, unsigned tag) {
  const int rounded = (density + (1 << (kDensityFractionBits - 1))) >> kDensityFractionBits;
  return std::size_t{tag} << 12 | static_cast<std::size_t>(rounded);
}

}  // namespace gicube::emu
