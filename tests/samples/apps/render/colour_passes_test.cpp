#include "render/colour_passes.h"

#include "gicube/scene/error.h"
#include "test.h"

namespace gicube::samples {
namespace {

SceneSetup example() {
  SceneSetup setup;
  setup.lighting.colour_passes = true;
  setup.lighting.exposure = 2;
  setup.lights = {PointLight{{0, 0, 0}, 10}, SphereLight{{1, 1, 1}, 1, 4}};
  setup.light_colours = {{1, 0.5, 0}, {1, 1, 1}};
  setup.optics = {{0.8, Bsdf::kDiffuse}, {0.5, Bsdf::kSpecular}};
  setup.scattering_colours = {{1, 0.25, 0}, {1, 1, 1}};
  return setup;
}

TEST(ColourPasses, AreOneWithoutThem) {
  SceneSetup setup = example();
  setup.lighting.colour_passes = false;
  const std::vector<LightPass> passes = passes_of(setup, 1);
  ASSERT_EQ(passes.size(), 1u);
  EXPECT_EQ(passes[0].lights.size(), 2u);
  EXPECT_STREQ(name_of(passes[0]), "all");
}

TEST(ColourPasses, ScaleLightsAndScatteringByTheirChannel) {
  const std::vector<LightPass> passes = passes_of(example(), 1);
  ASSERT_EQ(passes.size(), 3u);
  EXPECT_EQ(std::get<PointLight>(passes[0].lights[0]).power, 10);
  EXPECT_EQ(std::get<PointLight>(passes[1].lights[0]).power, 5);
  ASSERT_EQ(passes[2].lights.size(), 1u);  // the point light has no blue
  EXPECT_EQ(std::get<SphereLight>(passes[2].lights[0]).power, 4);
  EXPECT_EQ(passes[1].optics[0].scattering, 0.2);
  EXPECT_EQ(passes[2].optics[0].scattering, 0);
  EXPECT_EQ(passes[2].optics[1].scattering, 0.5);
  EXPECT_STREQ(name_of(passes[2]), "blue");
}

TEST(ColourPasses, OfColouredLightsNeedOneExposureForAll) {
  SceneSetup setup = example();
  setup.lighting.exposure = 0;
  EXPECT_THROW(passes_of(setup, 1), InputError);
  setup.light_colours[0] = {1, 1, 1};
  EXPECT_EQ(passes_of(setup, 1).size(), 3u);
}

TEST(ColourPasses, AreOneOnABoardOfThreeIrradianceWords) {
  SceneSetup setup = example();
  setup.lighting.exposure = 0;
  const std::vector<LightPass> passes = passes_of(setup, 3);
  ASSERT_EQ(passes.size(), 1u);
  EXPECT_EQ(passes[0].lights, setup.lights);
  EXPECT_EQ(passes[0].light_colours, setup.light_colours);
  EXPECT_EQ(passes[0].optics[0].scattering, 0.8);
  EXPECT_EQ(passes[0].optics[0].scattering_colour, (Colour{1, 0.25, 0}));
  EXPECT_EQ(pictures_of(passes[0]).size(), 1u);
}

TEST(ColourPasses, WithOneOfLightColouredMirrorsTakeAPictureForEachColour) {
  SceneSetup setup = example();
  setup.optics[0].seen_through_scattering = true;
  const std::vector<LightPass> pictures = pictures_of(passes_of(setup, 3)[0]);
  ASSERT_EQ(pictures.size(), 3u);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    EXPECT_EQ(pictures[channel].channel, static_cast<int>(channel));
    EXPECT_EQ(pictures[channel].optics[0].scattering, 0.8 * setup.scattering_colours[0][channel]);
    EXPECT_EQ(pictures[channel].optics[0].scattering_colour, (Colour{1, 1, 1}));
  }
  setup.optics[0].seen_through_scattering = false;
  setup.optics[1].seen_through_scattering = true;  // its scattering has no colour
  EXPECT_EQ(pictures_of(passes_of(setup, 3)[0]).size(), 1u);
}

TEST(ColourPasses, TakeEachChannelFromItsOwnPicture) {
  const Image pictures[] = {{1, 1, {{10, 20, 30, 1000}}}, {1, 1, {{11, 21, 31, 3000}}}, {1, 1, {{12, 22, 32, 2000}}}};
  Image result;
  for (int channel = 0; channel < 3; ++channel) put_together({channel, {}, {}, {}}, pictures[channel], {}, result);
  EXPECT_EQ(result.at(0, 0), (Pixel{10, 21, 32, 3000}));
}

TEST(ColourPasses, BlendTheBackgroundWithEachChannelsOwnAlpha) {
  const Image clear{1, 1, {{100, 100, 100, 0}}}, opaque{1, 1, {{100, 100, 100, 4095}}};
  const Colour background{0.2, 0.4, 1};
  Image result;
  put_together({0, {}, {}, {}}, clear, background, result);
  put_together({1, {}, {}, {}}, opaque, background, result);
  put_together({2, {}, {}, {}}, clear, background, result);
  EXPECT_EQ(result.at(0, 0), (Pixel{151, 100, 255, 4095}));
}

}  // namespace
}  // namespace gicube::samples
