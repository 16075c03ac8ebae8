// Input of each method of gicube-light: a scene and a picture of the light in it.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gicube/image.h"
#include "gicube/scene/scene.h"
#include "light/transport/optics.h"
#include "scene/names.h"
#include "scene/program/scene_input.h"

namespace gicube::samples {

struct LightInput {
  SceneInput scene;
  // Material of a volume without a scene's materials.
  Bsdf bsdf = Bsdf::kDiffuse;
  double albedo = 0.8;
  double step = 0.5;
  std::string camera_name;
  std::optional<std::array<int, 2>> size;
  double exposure = 0;                   // 0: chosen
  std::filesystem::path output, pixels;  // empty: none
};

void add_light_input(CLI::App& app, LightInput& input);
// Reads the scene and applies the options to it; sets it up. Throws what reading and setting up a scene throws.
Scene light_scene(const LightInput& input);
SceneSetup set_up_light(const Scene& scene, const LightInput& input, int threads);

// A pixel shows pi * radiance * exposure; 1 is white. Exposure 0: nine of ten lit pixels are below 0.8.
Image image_of(int width, int height, const std::vector<Rgb>& radiance, double exposure);

}  // namespace gicube::samples
