// What the reference renderer takes and gives: the same scene that a host gives a board, and a picture of doubles.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube::reference {

// The volume's memory must outlive the renderer. The view's jitter and leap are ignored: the reference has neither.
struct Scene {
  VolumeView volume;
  std::array<TransferFunction, 4> functions;  // by tag; one without points is invisible
  Shading shading;
  View view;
};

// Which of the board's roundings the reference repeats, so that the cost of each can be measured by itself.
struct Quantisers {
  bool density = false;      // 12-bit voxels, interpolated to 12.3
  bool gradient = false;     // the default codebook's 11-bit codes, 10-bit components, interpolated with five more bits
  bool colour = false;       // colours by 12-bit density, 12 bits a channel, as the ray's sum
  bool opacity = false;      // opacities by 12-bit density in 16 bits; 24 bits corrected and summed
  bool reflectance = false;  // an 8-bit cube map of 128^2 texels, coefficients in 1/128
  bool position = false;     // positions 10.14, directions 1.14, so steps too
  bool framebuffer = false;  // pixels of 8-8-8-12 bits

  static constexpr Quantisers all() { return {true, true, true, true, true, true, true}; }
};

// Colour premultiplied by opacity; each 0..1, display-referred.
struct Rgba {
  std::array<double, 3> colour{};
  double opacity = 0;

  friend bool operator==(const Rgba&, const Rgba&) = default;
};

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<Rgba> pixels;  // width * height, rows from the top

  const Rgba& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

// The colour of `front` over `back` [Porter and Duff 1984].
inline Rgba over(const Rgba& front, const Rgba& back) {
  Rgba both = front;
  for (std::size_t c = 0; c < 3; ++c) both.colour[c] += (1 - front.opacity) * back.colour[c];
  both.opacity += (1 - front.opacity) * back.opacity;
  return both;
}

}  // namespace gicube::reference
