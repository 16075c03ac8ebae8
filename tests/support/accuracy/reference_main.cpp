// gicube-reference: a scene's picture by the double-precision march of tests/support/reference, as an EXR of 32-bit
// floats in linear light, which gicube-sweep --reference-picture takes. The options are those of gicube-render; jitter
// and leaps are left out.
#include <OpenImageIO/imageio.h>

#include <exception>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "gicube/scene/image_file.h"
#include "reference/march.h"
#include "render/options.h"
#include "scenes.h"

namespace {

using namespace gicube;

void write(const reference::Picture& picture, const std::filesystem::path& file) {
  std::vector<float> values;
  for (const reference::Rgba& pixel : picture.pixels) {
    for (const double colour : pixel.colour) {
      const double shown = pixel.opacity > 0 ? colour / pixel.opacity : 0;
      values.push_back(static_cast<float>(pixel.opacity * samples::linear_light(shown)));
    }
    values.push_back(static_cast<float>(pixel.opacity));
  }
  const auto output = OIIO::ImageOutput::create(file.string());
  OIIO::ImageSpec spec(picture.width, picture.height, 4, OIIO::TypeDesc::FLOAT);
  if (!output || !output->open(file.string(), spec) || !output->write_image(OIIO::TypeDesc::FLOAT, values.data()) ||
      !output->close())
    throw std::runtime_error(file.string() + ": can't be written");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto options = samples::parse_options(argc, argv, std::cout);
    if (!options) return 0;
    samples::SceneSetup setup = samples::set_up(samples::scene_of(*options));
    samples::set_phong(*options, setup.shading.phong);
    write(reference::render(accuracy::to_reference(setup)), options->output);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "gicube-reference: " << error.what() << '\n';
    return 1;
  }
}
