// One pass for all colours of light, or one each for red, green and blue: on boards of one irradiance word.
#pragma once

#include <optional>
#include <vector>

#include "gicube/image.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::samples {

// A scene's light as one pass of lighting rays sees it.
struct LightPass {
  int channel = -1;  // 0 red, 1 green, 2 blue; -1 = all at once
  std::vector<Light> lights;
  std::vector<Colour> light_colours;  // of all colours at once, in three irradiance words; else none
  std::vector<Material> optics;       // by tag
};

const char* name_of(const LightPass& pass);

// One pass, or three whose lights and Ks are those of the channel; a channel without any light has no lights.
// `irradiance_words`: of the board; three have all colours in one pass. Throws InputError: coloured lights with an
// exposure that the driver would choose anew for each pass.
std::vector<LightPass> passes_of(const SceneSetup& setup, int irradiance_words);

// The pictures to be made with the pass's light: one, or one for each channel if light of three irradiance words is
// seen in coloured mirrors, because rays of a picture are scattered as one colour.
std::vector<LightPass> pictures_of(const LightPass& pass);

// Takes the pass's channel from `from` (take_channel()), or the whole picture.
void put_together(const LightPass& pass, const Image& from, const std::optional<Background>& background, Image& into);

}  // namespace gicube::samples
