// History of one ray, iteration by iteration, for gicube-render --explain-pixel.
//
// It uses the functions of interaction.h, like all fidelity levels, so the values are identical to theirs.
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

// One iteration of a ray through the pipeline.
struct RayIteration {
  Point position{};          // at the beginning
  std::size_t block = 0;     // block of this position
  std::int32_t skipped = 0;  // steps that were skipped; 0: a sample was taken, and the fields up to `alpha` describe it
  unsigned tag = 0;
  std::array<std::int16_t, 4> channels{};   // density and gradient; the gradient is only read for shading
  std::uint32_t entry = 0;                  // entry of the segmentation LUT
  Colour12 colour{};                        // classified, and shaded if the frame shades
  std::uint32_t alpha = 0;                  // opacity for the step's length, 2^24 - 1 = one
  bool scattered = false;                   // the ray continues in another direction
  std::array<std::uint16_t, 3> gathered{};  // after the iteration, premultiplied, 4095 = one
  std::uint32_t opacity = 0;                // after the iteration, 2^24 - 1 = one
};

struct RayLife {
  std::uint64_t number = 0;  // number in its source
  wire::Ray ray;             // at its end
  std::vector<RayIteration> iterations;
  // "left", "opaque", "absorbed"; "missed": the ray missed the volume; "host": it waits for the host's routine.
  const char* end = "";
};

// Traces a rendering ray. The frame must not be out of core, and its voxels must be decoded. The board does not change.
// Throws RoutineFault.
RayLife follow(const wire::Ray& ray, const Frame& frame);

}  // namespace gicube::emu
