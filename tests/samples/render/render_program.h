// Runs gicube-render with a private emulated board, and looks at what it made.
#pragma once

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace gicube::samples {

struct Outcome {
  int code = -1;
  std::string out, err;
};

class RenderProgram : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("gicube-") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  static std::string text_of(const std::string& file) {
    std::ifstream stream(file);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  Outcome run(const std::string& arguments) const {
    const std::string command =
        GICUBE_BIN_DIR "/gicube-render " + arguments + " >" + path("stdout") + " 2>" + path("stderr") + " </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(path("stdout")), text_of(path("stderr"))};
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

  std::filesystem::path folder_;
};

}  // namespace gicube::samples
