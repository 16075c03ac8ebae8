// The rays of one pixel of an image, for a debugging report.
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
  std::string refused;        // reason if there are no rays; otherwise empty
  std::vector<RayLife> rays;  // rays that contribute to the pixel, in the DSP's order
  wire::Pixel explained;      // pixel computed from these rays
  wire::Pixel pixel;          // pixel in the framebuffer
  // Frame data for showing numbers in the host's units.
  std::array<std::uint32_t, 3> blocks{};
};

struct ExplainedPixel {
  std::uint16_t x = 0, y = 0;                      // from the left, from the top
  std::function<void(const PixelLife&)> report{};  // called for each image, before its completion
};

}  // namespace gicube::emu
