// Runs gicube-render with a private emulated board, and looks at what it made.
#pragma once

#include <OpenImageIO/imageio.h>

#include "program_test.h"
#include "test.h"

namespace gicube::samples {

class RenderProgram : public ProgramTest {
 protected:
  RenderProgram() : ProgramTest("gicube-render") {}

  // All channels of all pixels; the files themselves also hold the command lines that made them.
  static std::vector<float> pixels_of(const std::string& file) {
    const auto input = OIIO::ImageInput::open(file);
    if (!input) return {};
    const OIIO::ImageSpec& spec = input->spec();
    std::vector<float> pixels(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()));
    return pixels;
  }

  // How many different colours an image has, its size checked.
  static std::size_t colours(const std::string& file, int width, int height) {
    const auto input = OIIO::ImageInput::open(file);
    if (!input) return 0;
    const OIIO::ImageSpec& spec = input->spec();
    EXPECT_EQ(spec.width, width);
    EXPECT_EQ(spec.height, height);
    const auto channels = static_cast<std::size_t>(spec.nchannels);
    std::vector<float> pixels(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) * channels);
    EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()));
    std::set<std::vector<float>> found;
    for (std::size_t i = 0; i < pixels.size(); i += channels) {
      found.emplace(pixels.begin() + static_cast<std::ptrdiff_t>(i),
                    pixels.begin() + static_cast<std::ptrdiff_t>(i + channels));
    }
    return found.size();
  }

  // Red, green, blue 0..1 of a pixel; y from the top.
  static std::array<float, 3> pixel(const std::string& file, int x, int y) {
    const auto input = OIIO::ImageInput::open(file);
    if (!input) return {-1, -1, -1};
    const auto width = static_cast<std::size_t>(input->spec().width),
               height = static_cast<std::size_t>(input->spec().height);
    const auto channels = static_cast<std::size_t>(input->spec().nchannels);
    std::vector<float> pixels(width * height * channels);
    EXPECT_TRUE(input->read_image(0, 0, 0, input->spec().nchannels, OIIO::TypeDesc::FLOAT, pixels.data()));
    const std::size_t at = (static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)) * channels;
    return {pixels[at], pixels[at + 1], pixels[at + 2]};
  }
};

}  // namespace gicube::samples
