#include "light/program/radiance_report.h"

#include <fmt/format.h>

#include <cmath>

#include "gicube/scene/image_file.h"
#include "scene/common/whole_file.h"
#include "scene/program/program.h"

namespace gicube::samples {
namespace {

void write_pixels(const RadiancePicture& picture, const std::filesystem::path& path) {
  std::string text = "x,y,red,green,blue,red_error,green_error,blue_error\n";
  const auto width = static_cast<std::size_t>(picture.width);
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    const Rgb &mean = picture.mean[i], &error = picture.error[i];
    text += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.3g},{:.3g},{:.3g}\n", i % width, i / width, mean[0], mean[1],
                        mean[2], error[0], error[1], error[2]);
  }
  write_whole(path, text);
}

}  // namespace

Noise noise_of(const RadiancePicture& picture) {
  Noise out;
  double squares = 0;
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      out.mean[c] += picture.mean[i][c] / static_cast<double>(picture.mean.size());
      squares += picture.error[i][c] * picture.error[i][c];
    }
  }
  const double all = out.mean[0] + out.mean[1] + out.mean[2];
  out.relative = 3 * std::sqrt(squares / static_cast<double>(3 * picture.mean.size())) / all;
  return out;
}

void print(const Noise& noise) {
  fmt::print("mean radiance {:.4g} {:.4g} {:.4g}; standard error of a pixel {:.1f}% of it\n", noise.mean[0],
             noise.mean[1], noise.mean[2], 100 * noise.relative);
  if (noise.mean == Rgb{}) {
    warn(
        "nothing is visible in the picture: no light reaches the eye, as without a lamp or with the camera turned "
        "away");
  }
}

nlohmann::ordered_json noise_json(const Noise& noise) {
  return std::isfinite(noise.relative) ? nlohmann::ordered_json(noise.relative) : nlohmann::ordered_json(nullptr);
}

void write_pictures(const RadiancePicture& picture, const LightInput& input, const Provenance& provenance) {
  if (!input.output.empty()) {
    write_image(image_of(picture.width, picture.height, picture.mean, input.exposure), input.output, Background(),
                provenance);
  }
  if (!input.pixels.empty()) write_pixels(picture, input.pixels);
}

}  // namespace gicube::samples
