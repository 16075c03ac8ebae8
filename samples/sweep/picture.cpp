#include "sweep/picture.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "gicube/scene/error.h"
#include "scene/names.h"

namespace gicube::samples::sweep {
namespace {

constexpr std::size_t kChannels = 4;

// IEC 61966-2-1.
float display_of(float linear) {
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}

std::size_t size_of(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// Two pixels of a row or column and how much of the second: where pixel `i` of `count` lies among `all`.
struct Between {
  std::size_t first = 0, second = 0;
  float share = 0;
};
Between between(int i, int count, int all) {
  const double at = std::clamp((i + 0.5) * all / count - 0.5, 0.0, all - 1.0);
  const auto first = static_cast<std::size_t>(at);
  return {first, std::min(first + 1, static_cast<std::size_t>(all) - 1),
          static_cast<float>(at - static_cast<double>(first))};
}

}  // namespace

Picture read_picture(const std::filesystem::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input) throw FileError(file, "picture", "an image that can be read", OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.nchannels != static_cast<int>(kChannels))
    throw FileError(file, "channels", "red, green, blue and alpha", std::to_string(spec.nchannels));
  Picture picture{spec.width, spec.height, std::vector<float>(kChannels * size_of(spec.width, spec.height))};
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, picture.values.data()))
    throw FileError(file, "picture", "whole pixels", input->geterror());
  for (std::size_t i = 0; i < picture.values.size(); i += kChannels) {
    const float alpha = picture.values[i + 3];
    if (alpha <= 0) continue;
    for (std::size_t c = 0; c < 3; ++c) picture.values[i + c] = alpha * display_of(picture.values[i + c] / alpha);
  }
  return picture;
}

Picture resized(const Picture& picture, int width, int height) {
  Picture out{width, height, {}};
  out.values.reserve(kChannels * size_of(width, height));
  const auto at = [&](std::size_t x, std::size_t y, std::size_t c) {
    return picture.values[kChannels * (y * static_cast<std::size_t>(picture.width) + x) + c];
  };
  for (int j = 0; j < height; ++j) {
    const Between y = between(j, height, picture.height);
    for (int i = 0; i < width; ++i) {
      const Between x = between(i, width, picture.width);
      for (std::size_t c = 0; c < kChannels; ++c) {
        const float above = at(x.first, y.first, c) * (1 - x.share) + at(x.second, y.first, c) * x.share;
        const float below = at(x.first, y.second, c) * (1 - x.share) + at(x.second, y.second, c) * x.share;
        out.values.push_back(above * (1 - y.share) + below * y.share);
      }
    }
  }
  return out;
}

double rmse(const Picture& picture, const Picture& reference) {
  if (picture.width != reference.width || picture.height != reference.height)
    return rmse(resized(picture, reference.width, reference.height), reference);
  double sum = 0;
  for (std::size_t i = 0; i < picture.values.size(); ++i) {
    const double off = double{picture.values[i]} - double{reference.values[i]};
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(picture.values.size()));
}

}  // namespace gicube::samples::sweep
