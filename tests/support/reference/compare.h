// How far a picture is from the reference.
#pragma once

#include "gicube/image.h"
#include "scene.h"

namespace gicube::reference {

// Over the red, green, blue (premultiplied) and alpha of all pixels of the full image, each 0..1 with peak 1. Empty
// background counts and makes a PSNR look better, so the figures of the covered pixels stand beside it: those where
// either picture has an alpha.
struct Difference {
  double psnr_db = 0;  // infinite for equal pictures
  double rmse = 0;
  double max_error = 0;
  double covered = 0;  // share of covered pixels, 0..1
  double covered_psnr_db = 0;
};

// Both throw std::invalid_argument if the sizes differ.
Difference compare(const Picture& picture, const Picture& reference);
// The board's words as they are, over 255 and 4095, against the reference's unquantised doubles.
Difference compare(const Image& image, const Picture& reference);

Picture to_picture(const Image& image);

}  // namespace gicube::reference
