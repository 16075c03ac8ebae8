#include "gicube/scene/image_file.h"

#include <OpenImageIO/imageio.h>

#include "full_disk.h"
#include "test.h"
#include "written_files.h"

namespace gicube::scene {
namespace {

// Opaque, half transparent, and empty.
Image three_pixels() { return {3, 1, {{255, 128, 0, 4095}, {100, 64, 0, 2048}, {0, 0, 0, 0}}}; }

struct Stored {
  OIIO::ImageSpec spec;
  std::vector<float> samples;
};

// What the file itself holds: OpenImageIO must not convert alpha. Bytes stay 0..255.
Stored load(const std::filesystem::path& path) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) return {};
  Stored stored{input->spec(), {}};
  stored.samples.resize(static_cast<std::size_t>(stored.spec.width * stored.spec.height * stored.spec.nchannels));
  input->read_image(0, 0, 0, stored.spec.nchannels, OIIO::TypeDesc::FLOAT, stored.samples.data());
  if (stored.spec.format == OIIO::TypeDesc::UINT8) {
    for (float& sample : stored.samples) sample = std::round(sample * 255);
  }
  return stored;
}

std::string write_error(const std::function<void()>& write) {
  return message_of<FileError>([&] { write(); });
}

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(ImageFile, PngHoldsStraightColoursAndAlpha) {
  const TemporaryFolder folder;
  write_png(three_pixels(), folder.path() / "a.png");
  const Stored stored = load(folder.path() / "a.png");
  EXPECT_EQ(stored.spec.format, OIIO::TypeDesc::UINT8);
  EXPECT_EQ(stored.spec.nchannels, 4);
  // 100 * 4095 / 2048 = 199.95, 64 * 4095 / 2048 = 127.97, 2048 * 255 / 4095 = 127.53.
  EXPECT_THAT(stored.samples, ElementsAre(255, 128, 0, 255, 200, 128, 0, 128, 0, 0, 0, 0));
}

TEST(ImageFile, PngOverABackgroundHasNoAlpha) {
  const TemporaryFolder folder;
  write_png(three_pixels(), folder.path() / "a.png", Colour{1, 0, 0.2});
  const Stored stored = load(folder.path() / "a.png");
  EXPECT_EQ(stored.spec.nchannels, 3);
  // 1 - 2048/4095 = 0.49988: 100 + 127.5, 64, 25.5; then the background itself.
  EXPECT_THAT(stored.samples, ElementsAre(255, 128, 0, 227, 64, 25, 255, 0, 51));
}

TEST(ImageFile, PngKeepsRowsFromTheTop) {
  const TemporaryFolder folder;
  write_png({1, 2, {{10, 10, 10, 4095}, {20, 20, 20, 4095}}}, folder.path() / "a.png", Colour{});
  EXPECT_THAT(load(folder.path() / "a.png").samples, ElementsAre(10, 10, 10, 20, 20, 20));
}

TEST(ImageFile, ColoursAboveTheirAlphaAreClamped) {
  const TemporaryFolder folder;
  write_png({1, 1, {{9, 0, 0, 16}}}, folder.path() / "a.png");
  EXPECT_THAT(load(folder.path() / "a.png").samples, ElementsAre(255, 0, 0, 1));
}

TEST(ImageFile, ExrHoldsLinearPremultipliedLight) {
  const TemporaryFolder folder;
  write_exr(three_pixels(), folder.path() / "a.exr");
  const Stored stored = load(folder.path() / "a.exr");
  EXPECT_EQ(stored.spec.format, OIIO::TypeDesc::FLOAT);
  ASSERT_EQ(stored.samples.size(), 12u);
  const double alpha = 2048 / 4095.0;
  // sRGB 128/255 is 0.2158605 in linear light.
  EXPECT_NEAR(stored.samples[1], 0.2158605, 1e-6);
  EXPECT_EQ(stored.samples[0], 1);
  EXPECT_EQ(stored.samples[2], 0);
  EXPECT_EQ(stored.samples[3], 1);
  EXPECT_NEAR(stored.samples[4], alpha * linear_light(100 / 255.0 / alpha), 1e-6);
  EXPECT_NEAR(stored.samples[5], alpha * linear_light(64 / 255.0 / alpha), 1e-6);
  EXPECT_NEAR(stored.samples[7], alpha, 1e-7);
  EXPECT_THAT(std::vector<float>(stored.samples.begin() + 8, stored.samples.end()), ElementsAre(0, 0, 0, 0));
}

// Alpha of 2048/4095 = 0.50012 and a display-referred colour of 0.7841 over black, white and itself.
TEST(ImageFile, ABackgroundIsMixedInDisplayValuesOrInLinearLight) {
  const double alpha = 2048 / 4095.0, colour = 100 / 255.0 / alpha;
  for (const double behind : {0.0, 1.0, colour}) {
    const Background display(Colour{behind, behind, behind});
    const Background linear(Colour{behind, behind, behind}, Composite::kLinear);
    const double light = alpha * linear_light(colour) + (1 - alpha) * linear_light(behind);
    EXPECT_NEAR(display.under(colour, alpha, 0), alpha * colour + (1 - alpha) * behind, 1e-12);
    EXPECT_NEAR(linear_light(linear.under(colour, alpha, 0)), light, 1e-7);
    EXPECT_NEAR(linear.under(colour, 1, 0), colour, 1e-7);
    EXPECT_NEAR(linear.under(colour, 0, 0), behind, 1e-7);

    const TemporaryFolder folder;
    write_exr(three_pixels(), folder.path() / "a.exr", linear);
    const Stored stored = load(folder.path() / "a.exr");
    ASSERT_EQ(stored.spec.nchannels, 3);
    EXPECT_NEAR(stored.samples[3], light, 1e-6);
    write_exr(three_pixels(), folder.path() / "a.exr", display);
    EXPECT_NEAR(load(folder.path() / "a.exr").samples[3], linear_light(alpha * colour + (1 - alpha) * behind), 1e-6);
  }
}

TEST(ImageFile, LinearLightFollowsTheSrgbCurve) {
  for (const double value : {0.0, 0.002, 0.04, 0.5, 1.0}) EXPECT_NEAR(display_value(linear_light(value)), value, 1e-7);
  EXPECT_EQ(linear_light(0), 0);
  EXPECT_DOUBLE_EQ(linear_light(1), 1);
  EXPECT_NEAR(linear_light(0.5), 0.2140411, 1e-7);
  EXPECT_NEAR(linear_light(0.04), 0.04 / 12.92, 1e-12);
}

TEST(ImageFile, ExtensionDecidesTheFormat) {
  const TemporaryFolder folder;
  write_image(three_pixels(), folder.path() / "a.PNG");
  write_image(three_pixels(), folder.path() / "a.exr");
  EXPECT_EQ(load(folder.path() / "a.PNG").spec.format, OIIO::TypeDesc::UINT8);
  EXPECT_EQ(load(folder.path() / "a.exr").spec.format, OIIO::TypeDesc::FLOAT);
  EXPECT_THAT(write_error([&] { write_image(three_pixels(), folder.path() / "a.gif"); }),
              HasSubstr(".png or .exr, got \".gif\""));
}

TEST(ImageFile, AFailureLeavesWhatWasThereAndNothingElse) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_error([&] { write_png(three_pixels(), folder.path() / "gone" / "a.png"); }),
              HasSubstr("gone/a.png: file"));
  std::filesystem::create_directories(folder.path() / "a.png" / "full");
  EXPECT_THAT(write_error([&] { write_png(three_pixels(), folder.path() / "a.png"); }), HasSubstr("a.png: file"));
  EXPECT_EQ(files_in(folder.path()), 1u);
  folder.write("b.png", "old");
  EXPECT_THAT(write_error([&] { write_png({2, 2, {}}, folder.path() / "b.png"); }), HasSubstr("2 x 2 and 0"));
  EXPECT_THAT(write_error([&] { write_exr({}, folder.path() / "b.png"); }), HasSubstr("image"));
  EXPECT_EQ(std::filesystem::file_size(folder.path() / "b.png"), 3u);
  write_png(three_pixels(), folder.path() / "b.png");
  EXPECT_EQ(load(folder.path() / "b.png").spec.width, 3);
  EXPECT_EQ(files_in(folder.path()), 2u);
}

// Noise, which no compression makes fit.
TEST(ImageFile, AFullDiskIsToldAndLeavesWhatWasThere) {
  Image noise{64, 64, {}};
  std::mt19937 random;
  for (int i = 0; i < 64 * 64; ++i) {
    const auto byte = [&random] { return static_cast<std::uint8_t>(random()); };
    noise.pixels.push_back({byte(), byte(), byte(), 4095});
  }
  for (const char* name : {"a.png", "a.exr"}) {
    for (const std::size_t room : {std::size_t{0}, reference::kDiskBlock}) {
      reference::expect_full_disk_leaves_nothing(name, room,
                                                 [&](const std::string& file) { write_image(noise, file); });
    }
  }
}

}  // namespace
}  // namespace gicube::scene
