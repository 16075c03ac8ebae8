// The rays of one pixel of a picture, for whoever asked for them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "firmware/ray_life.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

struct PixelLife {
  std::uint16_t x = 0, y = 0;
  std::string refused;        // why there are no rays; empty: there are
  std::vector<RayLife> rays;  // that the pixel is made of, in the DSP's order
  wire::Pixel explained;      // what they make
  wire::Pixel pixel;          // what the framebuffer has
  // Of the frame, to show numbers in the host's units.
  std::array<std::uint32_t, 3> blocks{};
};

struct ExplainedPixel {
  std::uint16_t x = 0, y = 0;                    // from the left, from the top
  std::function<void(const PixelLife&)> tell{};  // with each picture, before its completion
};

}  // namespace gicube::emu
