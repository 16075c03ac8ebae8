// What happens to one ray from its start to its end, pass by pass: for gicube-render --explain-pixel.
//
// The passes are those of interaction.h, which every fidelity level takes, so the values are the levels' own to the last bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "datapath/frame.h"
#include "datapath/shade.h"
#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

// One pass through the pipeline.
struct RayPass {
  Point position{};       // at which it begins
  std::size_t block = 0;  // there
  std::int32_t leap = 0;  // steps that a leap took; 0: the pass took a sample, of which is what follows up to `alpha`
  unsigned tag = 0;
  std::array<std::int16_t, 4> channels{};   // density and gradient; without shading no gradient is read
  std::uint32_t entry = 0;                  // of the segmentation LUT
  Colour12 colour{};                        // classified, and shaded if the frame shades
  std::uint32_t alpha = 0;                  // opacity for the step's length, 2^24 - 1 = one
  bool scattered = false;                   // the ray goes on in another direction
  std::array<std::uint16_t, 3> gathered{};  // after the pass, premultiplied, 4095 = one
  std::uint32_t opacity = 0;                // likewise, 2^24 - 1 = one
};

struct RayLife {
  std::uint64_t number = 0;  // in its source
  wire::Ray ray;             // as it ends
  std::vector<RayPass> passes;
  // "left", "opaque", "absorbed"; "missed": it met no voxel; "host": it waits for the host's routine.
  const char* end = "";
};

// Follows a rendering ray of a frame that is not in bricks, whose voxels are decoded. Nothing of the board changes. Throws
// RoutineFault.
RayLife follow(const wire::Ray& ray, const Frame& frame);

}  // namespace gicube::emu
