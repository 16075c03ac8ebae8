#include "compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace gicube::reference {

namespace {

constexpr double kChannels = 4;

double to_psnr(double mean_square) {
  return mean_square == 0 ? std::numeric_limits<double>::infinity() : -10 * std::log10(mean_square);
}

std::string size_text(const Picture& picture) {
  return std::to_string(picture.width) + "x" + std::to_string(picture.height);
}

}  // namespace

Difference compare(const Picture& picture, const Picture& reference) {
  if (picture.width != reference.width || picture.height != reference.height) {
    throw std::invalid_argument("pictures of " + size_text(picture) + " and " + size_text(reference) + " pixels");
  }
  Difference difference;
  double squares = 0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const Rgba &a = picture.pixels[i], &b = reference.pixels[i];
    if (a.opacity > 0 || b.opacity > 0) ++covered;
    for (std::size_t c = 0; c < 4; ++c) {
      const double error = c < 3 ? a.colour[c] - b.colour[c] : a.opacity - b.opacity;
      squares += error * error;
      difference.max_error = std::max(difference.max_error, std::abs(error));
    }
  }
  const auto pixels = static_cast<double>(picture.pixels.size());
  difference.rmse = std::sqrt(squares / (kChannels * pixels));
  difference.psnr_db = to_psnr(squares / (kChannels * pixels));
  difference.covered = static_cast<double>(covered) / pixels;
  // Elsewhere both pictures are zero.
  difference.covered_psnr_db = to_psnr(covered == 0 ? 0 : squares / (kChannels * static_cast<double>(covered)));
  return difference;
}

Difference compare(const Image& image, const Picture& reference) { return compare(to_picture(image), reference); }

Picture to_picture(const Image& image) {
  Picture picture{image.width, image.height, {}};
  picture.pixels.reserve(image.pixels.size());
  for (const Pixel& pixel : image.pixels) {
    picture.pixels.push_back({{pixel.red / 255.0, pixel.green / 255.0, pixel.blue / 255.0}, pixel.alpha / 4095.0});
  }
  return picture;
}

}  // namespace gicube::reference
