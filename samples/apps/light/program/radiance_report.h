// Printed and written reports of a radiance picture.
#pragma once

#include <nlohmann/json.hpp>

#include "light/program/light_input.h"
#include "light/transport/radiance.h"

namespace gicube::samples {

struct Noise {
  Rgb mean{};
  double relative = 0;  // root mean square of the pixels' standard errors over the mean radiance of all channels
};
Noise noise_of(const RadiancePicture& picture);
void print(const Noise& noise);                         // with a warning if the picture is black
nlohmann::ordered_json noise_json(const Noise& noise);  // the relative error; null for one pass

// To LightInput::output and pixels, where these are given. Throws FileError.
void write_pictures(const RadiancePicture& picture, const LightInput& input, const Provenance& provenance);

}  // namespace gicube::samples
