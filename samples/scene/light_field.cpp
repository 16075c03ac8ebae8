#include "scene/light_field.h"

#include <algorithm>
#include <cmath>

namespace gicube::samples {
namespace {

constexpr double kWhite = 0.8;    // of full scale, for
constexpr double kShare = 0.9;    // of the values that show any light
constexpr double kBrightest = 4;  // times white
constexpr double kWords = 2047;   // the paper's irradiance words; of the wide ones the upper parts count so many
constexpr double kOpaque = 4095;  // alpha

}  // namespace

double exposure_for(const LightField& field) {
  std::vector<float> lit;
  std::copy_if(field.values.begin(), field.values.end(), std::back_inserter(lit), [](float v) { return v > 0; });
  if (lit.empty()) return 1;
  const auto at = lit.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(lit.size() - 1));
  std::nth_element(lit.begin(), at, lit.end());
  return kWhite / *at;
}

void put_on(Board& board, const LightField& field, int channel, double exposure) {
  const auto stride = static_cast<std::size_t>(field.channels);
  std::vector<float> values(field.values.size() / stride);
  const double most = kBrightest / exposure;
  double brightest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = std::min(field.values[i * stride + static_cast<std::size_t>(channel)], static_cast<float>(most));
    brightest = std::max(brightest, double{values[i]});
  }
  const double words = kWords * (board.info().wide ? 65536.0 : 1.0);
  board.clear_irradiance(brightest > 0 ? brightest / words : 1);
  board.write_irradiance({{0, 0, 0}, field.dims}, values);
}

Image picture_of(Board& board, const LightField& field, View view, double exposure,
                 const std::optional<Colour>& background, const Progress& progress) {
  view.irradiance = view.incident = true;
  view.exposure = exposure;
  Image picture;
  constexpr std::uint8_t Pixel::*kChannels[] = {&Pixel::red, &Pixel::green, &Pixel::blue};
  for (int channel = 0; channel < field.channels; ++channel) {
    put_on(board, field, channel, exposure);
    const Image pass = board.render(view, progress);
    if (channel == 0) picture = pass;
    const auto part = kChannels[channel];
    for (std::size_t i = 0; i < pass.pixels.size(); ++i) picture.pixels[i].*part = pass.pixels[i].*part;
  }
  if (!background) return picture;
  for (Pixel& pixel : picture.pixels) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double over = pixel.*kChannels[c] + (1 - pixel.alpha / kOpaque) * 255 * (*background)[c];
      pixel.*kChannels[c] = static_cast<std::uint8_t>(std::min(std::lround(over), 255L));
    }
    pixel.alpha = static_cast<std::uint16_t>(kOpaque);
  }
  return picture;
}

}  // namespace gicube::samples
