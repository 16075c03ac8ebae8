#include "light/program/light_input.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gicube/scene/image_file.h"
#include "scene/program/option_group.h"

namespace gicube::samples {

void add_light_input(CLI::App& app, LightInput& input) {
  add_scene_input(app, input.scene);
  OptionGroup scene(app, "Scene");
  scene.choice("--bsdf", input.bsdf, {{"diffuse", Bsdf::kDiffuse}, {"isotropic", Bsdf::kIsotropic}},
               "BSDF of a volume without a scene's materials (diffuse)");
  scene.number("--albedo", input.albedo, CLI::Range(0.0, 1.0), "albedo of such a volume");
  OptionGroup picture(app, "Picture");
  picture.file("-o,--output", input.output, "write the picture here, PNG or EXR");
  picture.file("--pixels", input.pixels, "write each pixel's radiance and its standard error here, CSV");
  picture.value("--camera", input.camera_name, "name of the scene's camera to use (the first)")->type_name("NAME");
  picture.size("--size", input.size, "size of the picture, pixels (the scene's)");
  picture.number("--exposure", input.exposure, CLI::Range(0.0, 1e12),
                 "brightness of a white surface with a unit of power per unit of area; 0: chosen");
  picture.number("--step", input.step, CLI::Range(1.0 / 64, 16.0), "step of the board's rays, voxels");
}

Scene light_scene(const LightInput& input) {
  Scene scene = scene_of(input.scene);
  if (!input.camera_name.empty()) choose_camera(scene, input.camera_name);
  if (input.size) scene.view.width = (*input.size)[0], scene.view.height = (*input.size)[1];
  scene.lighting.on = true;
  return scene;
}

SceneSetup set_up_light(const Scene& scene, const LightInput& input, int threads) {
  SceneSetup setup = set_up(scene, threads);
  if (scene.materials.empty()) {
    setup.optics.assign(setup.materials.size(), {.scattering = input.albedo, .bsdf = input.bsdf});
    setup.emissions.assign(setup.materials.size(), {0, 0, 0});
    setup.scattering_colours.clear();
    for (const TransferFunctionFile& look : setup.materials) {
      // Linear light of the colour at the greatest opacity.
      const auto& opacities = look.function.opacities;
      const auto most = std::ranges::max_element(opacities, {}, &OpacityPoint::opacity);
      Colour colour{1, 1, 1};
      if (most != opacities.end() && !look.function.colours.empty()) colour = look.function.colour_at(most->value);
      for (double& part : colour) part = linear_light(part);
      setup.scattering_colours.push_back(colour);
    }
  }
  return setup;
}

Image image_of(int width, int height, const std::vector<Rgb>& radiance, double exposure) {
  if (exposure == 0) {
    std::vector<double> lit;
    for (const Rgb& pixel : radiance) {
      if (std::ranges::max(pixel) > 0) lit.push_back(std::ranges::max(pixel));
    }
    constexpr double kBelow = 0.9, kLinear = 0.6;  // 0.8 on a display
    if (!lit.empty()) {
      const auto at = lit.begin() + static_cast<std::ptrdiff_t>(kBelow * static_cast<double>(lit.size() - 1));
      std::ranges::nth_element(lit, at);
      exposure = kLinear / (std::numbers::pi * *at);
    }
  }
  Image image{width, height, {}};
  for (const Rgb& pixel : radiance) {
    const auto byte = [&](std::size_t c) {
      const double linear = std::clamp(exposure * std::numbers::pi * pixel[c], 0.0, 1.0);
      return static_cast<std::uint8_t>(std::lround(255 * display_value(linear)));
    };
    image.pixels.push_back({byte(0), byte(1), byte(2), 4095});
  }
  return image;
}

}  // namespace gicube::samples
