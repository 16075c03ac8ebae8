#include "gicube/scene/light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gicube/scene/volume_file.h"
#include "scene/formats/compressed_nrrd.h"
#include "scene/formats/readers.h"

namespace gicube::scene {
namespace {

constexpr double kWhite = 0.8;    // of full scale, at the quantile kShare
constexpr double kShare = 0.9;    // of the values above 0
constexpr double kBrightest = 4;  // times white
constexpr double kWords = 2047;   // the largest of the paper's irradiance words, and of the upper parts of wide ones
constexpr double kOpaque = 4095;  // alpha

std::size_t irradiance_words(const Board& board) { return static_cast<std::size_t>(board.info().irradiance_words); }

// Replaces the board's irradiance by a channel; with three irradiance words, by all channels from `channel` on.
void put_on(Board& board, const LightField& field, int channel, double exposure) {
  const auto stride = static_cast<std::size_t>(field.channels), words = irradiance_words(board);
  std::vector<float> values(field.values.size() / stride * words);
  const double most = kBrightest / exposure;
  double brightest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t of_voxel = std::min(static_cast<std::size_t>(channel) + i % words, stride - 1);
    values[i] = std::min(field.values[i / words * stride + of_voxel], static_cast<float>(most));
    brightest = std::max(brightest, double{values[i]});
  }
  const double full = kWords * (board.info().wide ? 65536.0 : 1.0);
  board.clear_irradiance(brightest > 0 ? brightest / full : 1);
  board.write_irradiance({{0, 0, 0}, field.dims}, values);
}

}  // namespace

void write_light_field(const LightField& field, Vec3 spacing, Vec3 origin, const std::filesystem::path& path,
                       const Provenance& provenance) {
  write_compressed_nrrd({field.dims, spacing, origin, field.values, field.channels}, path, provenance);
}

LightField read_light_field(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path) || !is_nrrd(path)) {
    throw FileError(path, "file", "an NRRD file", "another or none");
  }
  LightField field;
  const Volume volume = read_nrrd_channels(path, field.channels);
  if (volume.type != SampleType::kFloat32) throw FileError(path, "type", "float", "integers");
  field.dims = volume.dims;
  field.dims[0] /= field.channels;
  field.values.resize(volume.samples.size() / sizeof(float));
  std::memcpy(field.values.data(), volume.samples.data(), volume.samples.size());
  for (const float value : field.values) {
    if (!(value >= 0 && std::isfinite(value))) {
      throw FileError(path, "values", "finite numbers, 0 or more", fmt::format("{}", value));
    }
  }
  return field;
}

void take_channel(const Image& from, int channel, const std::optional<Background>& background, Image& into) {
  if (into.pixels.empty()) into = {from.width, from.height, std::vector<Pixel>(from.pixels.size())};
  constexpr std::uint8_t Pixel::*kChannels[] = {&Pixel::red, &Pixel::green, &Pixel::blue};
  const auto index = static_cast<std::size_t>(channel);
  for (std::size_t i = 0; i < into.pixels.size(); ++i) {
    const Pixel& source = from.pixels[i];
    Pixel& target = into.pixels[i];
    double value = source.*kChannels[index];
    const double alpha = std::min(source.alpha / kOpaque, 1.0);
    if (background && background->composite == Composite::kDisplay) {
      value += (1 - alpha) * 255 * background->colour[index];
    } else if (background) {
      const double straight = alpha > 0 ? std::min(value / 255 / alpha, 1.0) : 0;
      value = 255 * background->under(straight, alpha, index);
    }
    target.*kChannels[index] = static_cast<std::uint8_t>(std::min(std::lround(value), 255L));
    target.alpha = background ? static_cast<std::uint16_t>(kOpaque) : std::max(target.alpha, source.alpha);
  }
}

double exposure_for(const LightField& field) {
  std::vector<float> lit;
  std::copy_if(field.values.begin(), field.values.end(), std::back_inserter(lit), [](float v) { return v > 0; });
  if (lit.empty()) return 1;
  const auto at = lit.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(lit.size() - 1));
  std::nth_element(lit.begin(), at, lit.end());
  return kWhite / *at;
}

Image picture_of(Board& board, const LightField& field, View view, double exposure,
                 const std::optional<Background>& background, const Progress& progress) {
  view.irradiance = view.incident = true;
  view.lamps.clear();  // the field's light has another unit
  view.exposure = exposure;
  Image picture;
  if (irradiance_words(board) > 1) {
    put_on(board, field, 0, exposure);
    const Image all = board.render(view, progress);
    for (int channel = 0; channel < 3; ++channel) take_channel(all, channel, background, picture);
    return picture;
  }
  for (int channel = 0; channel < field.channels; ++channel) {
    put_on(board, field, channel, exposure);
    const Image pass = board.render(view, progress);
    const int last = field.channels > 1 ? channel : 2;  // light of one channel is white
    for (int shown = channel; shown <= last; ++shown) take_channel(pass, shown, background, picture);
  }
  return picture;
}

}  // namespace gicube::scene
