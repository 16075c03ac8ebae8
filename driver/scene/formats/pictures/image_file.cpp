#include "gicube/scene/image_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/formats/pictures/picture_library.h"
#include "scene/formats/pictures/png_file.h"

namespace gicube::scene {
namespace {

// The pixel's alpha, and its colour not premultiplied; 0..1.
struct Straight {
  std::array<double, 3> colour{};
  double alpha = 0;
};

Straight straight(const Pixel& pixel) {
  Straight result;
  result.alpha = std::min(pixel.alpha / 4095.0, 1.0);
  if (pixel.alpha == 0) return result;
  const std::array<std::uint8_t, 3> stored = {pixel.red, pixel.green, pixel.blue};
  for (std::size_t c = 0; c < 3; ++c) {
    // Rounding can leave a colour slightly above its alpha.
    result.colour[c] = std::min(stored[c] / 255.0 / result.alpha, 1.0);
  }
  return result;
}

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))); }

void check(const Image& image, const std::filesystem::path& path) {
  const bool sized = image.width > 0 && image.height > 0;
  const auto pixels = sized ? static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) : 0;
  if (sized && pixels == image.pixels.size()) return;
  throw FileError(path, "image", "width x height pixels, at least one",
                  fmt::format("{} x {} and {}", image.width, image.height, image.pixels.size()));
}

std::vector<std::pair<std::string, std::string>> texts_of(const Provenance& provenance) {
  auto texts = entries(provenance);
  texts.insert(texts.begin(), {"Software", "GI-Cube"});
  return texts;
}

void write(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  write_whole(path, [&bytes](WholeFile& file) { file.write(std::span(bytes)); });
}

}  // namespace

double linear_light(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}

double display_value(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double Background::under(double value, double alpha, std::size_t channel) const {
  const double behind = colour[channel];
  if (composite == Composite::kDisplay) return alpha * value + (1 - alpha) * behind;
  return display_value(alpha * linear_light(value) + (1 - alpha) * linear_light(behind));
}

std::vector<std::uint8_t> png_pixels(const Image& image, const std::optional<Background>& background) {
  check(image, "a picture");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.pixels.size() * (background ? 3 : 4));
  for (const Pixel& pixel : image.pixels) {
    const Straight seen = straight(pixel);
    for (std::size_t c = 0; c < 3; ++c) {
      bytes.push_back(to_byte(background ? background->under(seen.colour[c], seen.alpha, c) : seen.colour[c]));
    }
    if (!background) bytes.push_back(to_byte(seen.alpha));
  }
  return bytes;
}

void write_png(const Image& image, const std::filesystem::path& path, const std::optional<Background>& background,
               const Provenance& provenance) {
  check(image, path);
  const int channels = background ? 3 : 4;
  const std::vector<std::uint8_t> bytes = png_pixels(image, background);
  write(path, encoded_png(path, {image.width, image.height, channels, bytes, texts_of(provenance)}));
}

void write_exr(const Image& image, const std::filesystem::path& path, const std::optional<Background>& background,
               const Provenance& provenance) {
  check(image, path);
  const int channels = background ? 3 : 4;
  std::vector<float> floats;
  floats.reserve(image.pixels.size() * static_cast<std::size_t>(channels));
  for (const Pixel& pixel : image.pixels) {
    const Straight seen = straight(pixel);
    for (std::size_t c = 0; c < 3; ++c) {
      const double light = background ? linear_light(background->under(seen.colour[c], seen.alpha, c))
                                      : seen.alpha * linear_light(seen.colour[c]);
      floats.push_back(static_cast<float>(light));
    }
    if (!background) floats.push_back(static_cast<float>(seen.alpha));
  }
  PictureToWrite picture{"openexr", image.width, image.height, channels, floats.data(), texts_of(provenance)};
  // Or OpenImageIO would put the time of day there, and no two files were alike.
  picture.attributes.emplace_back("DateTime", "");
  picture.attributes.emplace_back("oiio:ColorSpace", "Linear");
  picture.attributes.emplace_back("compression", "zip");
  write(path, encoded_picture(path, picture));
}

void write_image(const Image& image, const std::filesystem::path& path, const std::optional<Background>& background,
                 const Provenance& provenance) {
  const std::string extension = lower_case(path.extension().string());
  if (extension == ".png") return write_png(image, path, background, provenance);
  if (extension != ".exr") throw FileError(path, "extension", ".png or .exr", '"' + extension + '"');
  write_exr(image, path, background, provenance);
}

}  // namespace gicube::scene
