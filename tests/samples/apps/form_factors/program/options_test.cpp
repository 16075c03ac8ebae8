#include "form_factors/program/options.h"

#include "test.h"

namespace gicube::samples {
namespace {

std::optional<FormFactorOptions> parsed(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "gicube-form-factors");
  std::ostringstream out;
  return parse_form_factor_options(static_cast<int>(arguments.size()), arguments.data(), out);
}

SolveOptions solve_options(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "solve");
  return std::get<SolveOptions>(*parsed(std::move(arguments)));
}

std::string refusal(const std::vector<const char*>& arguments) {
  return message_of<UsageError>([&] { parsed(arguments); });
}

TEST(FormFactorOptions, OfASolutionSetItsMethodAndItsFiles) {
  const SolveOptions options = solve_options({"a.scene",
                                              "--volume-size",
                                              "40",
                                              "--error",
                                              "1e-3",
                                              "--rays",
                                              "32",
                                              "--max-rays",
                                              "4096",
                                              "--step",
                                              "0.5",
                                              "--solid-opacity",
                                              "0.8",
                                              "--solver",
                                              "shooting",
                                              "--made",
                                              "host",
                                              "--full-matrix",
                                              "--leaf-voxels",
                                              "2",
                                              "--convergence",
                                              "1e-6",
                                              "--iterations",
                                              "50",
                                              "--seed",
                                              "7",
                                              "--emission",
                                              "2=5",
                                              "--emission",
                                              "1=1,0.5,0",
                                              "--albedo",
                                              "0=0.9",
                                              "--factors",
                                              "f.mtx",
                                              "--solution",
                                              "s.nrrd",
                                              "-o",
                                              "p.png",
                                              "--size",
                                              "64x48",
                                              "--exposure",
                                              "2",
                                              "--stats",
                                              "s.json"});
  EXPECT_EQ(options.input.input, "a.scene");
  EXPECT_EQ(options.input.volume_size, 40);
  EXPECT_EQ(options.settings.error, 1e-3);
  EXPECT_EQ(options.settings.rays, 32);
  EXPECT_EQ(options.settings.max_rays, 4096);
  EXPECT_EQ(options.settings.step, 0.5);
  EXPECT_EQ(options.settings.solid_opacity, 0.8);
  EXPECT_EQ(options.settings.solver, Solver::kShooting);
  EXPECT_EQ(options.settings.made, PairRays::kByHost);
  EXPECT_FALSE(options.settings.hierarchy);
  EXPECT_EQ(options.settings.leaf_voxels, 2);
  EXPECT_EQ(options.settings.convergence, 1e-6);
  EXPECT_EQ(options.settings.max_iterations, 50);
  EXPECT_EQ(options.settings.seed, 7u);
  ASSERT_EQ(options.emissions.size(), 2u);
  EXPECT_EQ(options.emissions[0].tag, 2);
  EXPECT_EQ(options.emissions[0].value, (Power{5, 5, 5}));
  EXPECT_EQ(options.emissions[1].value, (Power{1, 0.5, 0}));
  EXPECT_EQ(options.albedos[0].value, (Power{0.9, 0.9, 0.9}));
  EXPECT_EQ(options.factors, "f.mtx");
  EXPECT_EQ(options.solution, "s.nrrd");
  EXPECT_EQ(options.picture, "p.png");
  EXPECT_EQ(options.size, (std::array{64, 48}));
  EXPECT_EQ(options.exposure, 2);
}

TEST(FormFactorOptions, WithoutWishesAreTheMethodsOwn) {
  const RadiositySettings settings = solve_options({"a.scene"}).settings, own;
  EXPECT_EQ(settings.error, own.error);
  EXPECT_EQ(settings.rays, own.rays);
  EXPECT_TRUE(settings.hierarchy);
  EXPECT_EQ(settings.solver, Solver::kGathering);
  const auto visibility =
      std::get<VisibilityOptions>(*parsed({"visibility", "a.nrrd", "--pairs", "5", "--made", "host"}));
  EXPECT_EQ(visibility.pairs, 5u);
  EXPECT_EQ(visibility.made, PairRays::kByHost);
}

TEST(FormFactorOptions, WhatIsWrongIsNamed) {
  EXPECT_THAT(refusal({}), HasSubstr("subcommand"));
  EXPECT_THAT(refusal({"solve"}), HasSubstr("INPUT"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--error", "0"}), HasSubstr("--error"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--emission", "4=1"}), HasSubstr("--emission: expected TAG=VALUE"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--emission", "1=1,2"}), HasSubstr("--emission: expected 3 numbers"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--emission", "1=-1"}), HasSubstr("--emission"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--albedo", "1=1.5"}), HasSubstr("numbers from 0 to 1, got \"1=1.5\""));
  EXPECT_THAT(refusal({"solve", "a.scene", "-o", "a.jpg"}), HasSubstr("--output: expected a name that ends in .png"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--leaf-voxels", "3"}), HasSubstr("--leaf-voxels: expected a power of two"));
  EXPECT_THAT(refusal({"solve", "a.scene", "--rays", "64", "--max-rays", "32"}),
              HasSubstr("--max-rays: expected 64 (--rays) or more, got 32"));
  EXPECT_THAT(refusal({"visibility", "a.scene", "--pairs", "0"}), HasSubstr("--pairs"));
}

TEST(RadiosityScenes, OfTheSourceTreeAreReadAndSendOutLight) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GICUBE_SOURCE_DIR "/samples/scenes/radiosity")) {
    SceneInput input;
    input.input = entry.path();
    input.volume_size = 32;
    input.allow_outside = true;
    const Scene scene = scene_of(input);
    EXPECT_TRUE(std::any_of(scene.materials.begin(), scene.materials.end(), [](const auto& m) {
      return m.emission > 0;
    })) << entry.path();
    EXPECT_EQ(scene.world->size, 32);
    ++scenes;
  }
  EXPECT_EQ(scenes, 3);
}

TEST(FormFactorOptions, MaterialsTakeTheEmissionsAndAlbedosOfTheirTags) {
  Scene scene;
  SceneMaterial paper;
  paper.name = "paper", paper.tag = 1, paper.emission = 9;
  scene.materials = {paper};
  set_materials(solve_options({"a.scene", "--emission", "1=4,2,0", "--albedo", "0=0.25,0.5,0", "--emission", "3=0"}),
                scene);
  ASSERT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].emission, 4);
  EXPECT_EQ(scene.materials[0].emission_colour, (Colour{1, 0.5, 0}));
  const auto made =
      std::find_if(scene.materials.begin(), scene.materials.end(), [](const auto& m) { return m.tag == 0; });
  ASSERT_NE(made, scene.materials.end());
  EXPECT_EQ(made->optics.scattering, 0.5);
  EXPECT_EQ(made->scattering_colour, (Colour{0.5, 1, 0}));
  EXPECT_EQ(made->optics.bsdf, Bsdf::kDiffuse);
}

}  // namespace
}  // namespace gicube::samples
