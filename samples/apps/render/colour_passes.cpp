#include "render/colour_passes.h"

#include <algorithm>

#include "gicube/scene/error.h"
#include "gicube/scene/light_field.h"

namespace gicube::samples {

const char* name_of(const LightPass& pass) {
  constexpr const char* kNames[] = {"all", "red", "green", "blue"};
  return kNames[pass.channel + 1];
}

std::vector<LightPass> passes_of(const SceneSetup& setup, int irradiance_words) {
  if (!setup.lighting.colour_passes) return {{-1, setup.lights, {}, setup.optics}};
  if (irradiance_words > 1) {
    LightPass pass{-1, setup.lights, setup.light_colours, setup.optics};
    for (std::size_t tag = 0; tag < pass.optics.size(); ++tag) {
      pass.optics[tag].scattering_colour = setup.scattering_colours[tag];
    }
    return {pass};
  }
  const bool coloured = std::any_of(setup.light_colours.begin(), setup.light_colours.end(), [](const Colour& colour) {
    return colour != Colour{1, 1, 1};
  });
  if (coloured && setup.lighting.exposure == 0) {
    throw InputError("illumination.exposure", "a number with coloured lights, the same for red, green and blue",
                     "none");
  }
  std::vector<LightPass> passes;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    LightPass pass{static_cast<int>(channel), {}, {}, setup.optics};
    for (std::size_t i = 0; i < setup.lights.size(); ++i) {
      const double factor = setup.light_colours[i][channel];
      if (factor > 0) pass.lights.push_back(scaled(setup.lights[i], factor));
    }
    for (std::size_t tag = 0; tag < pass.optics.size(); ++tag) {
      pass.optics[tag].scattering *= setup.scattering_colours[tag][channel];
    }
    passes.push_back(std::move(pass));
  }
  return passes;
}

std::vector<LightPass> pictures_of(const LightPass& pass) {
  constexpr Colour kWhite{1, 1, 1};
  const bool mirrors_colour = std::ranges::any_of(pass.optics, [&](const Material& material) {
    return material.seen_through_scattering && material.scattering_colour != kWhite;
  });
  if (!mirrors_colour) return {pass};
  std::vector<LightPass> pictures;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    LightPass picture = pass;
    picture.channel = static_cast<int>(channel);
    for (Material& material : picture.optics) {
      material.scattering *= material.scattering_colour[channel];
      material.scattering_colour = kWhite;
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

void put_together(const LightPass& pass, const Image& from, const std::optional<Background>& background, Image& into) {
  if (pass.channel < 0) {
    into = from;
  } else {
    take_channel(from, pass.channel, background, into);
  }
}

}  // namespace gicube::samples
