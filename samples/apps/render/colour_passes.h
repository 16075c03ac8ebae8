// One pass for all colours of light, or one each for red, green and blue: on boards of one irradiance word.
#pragma once

#include <optional>
#include <vector>

#include "gicube/image.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::samples {

// A scene's light in one pass of lighting rays.
struct LightPass {
  int channel = -1;  // 0 red, 1 green, 2 blue; -1 = all at once
  std::vector<Light> lights;
  std::vector<Colour> light_colours;  // if all colours are in one pass, with three irradiance words; otherwise empty
  std::vector<Material> optics;       // by tag
};

const char* name_of(const LightPass& pass);

// One pass, or three, each with the lights and Ks of its channel; a channel without light has no lights.
// `irradiance_words`: of the board; with three, one pass has all colours. Throws InputError: coloured lights without an
// exposure, which the driver would choose differently for each pass.
std::vector<LightPass> passes_of(const SceneSetup& setup, int irradiance_words);

// The pictures for the pass's light: one, or one for each channel if coloured mirrors show light of three irradiance
// words, because a picture's rays are scattered with one colour.
std::vector<LightPass> pictures_of(const LightPass& pass);

// Copies the pass's channel from `from` (take_channel()), or the whole picture.
void put_together(const LightPass& pass, const Image& from, const std::optional<Background>& background, Image& into);

}  // namespace gicube::samples
