// --max-error, --time-budget and --explain.
#include <nlohmann/json.hpp>

#include "render_program.h"
#include "scene/program/plan_options.h"
#include "test.h"

namespace gicube::samples {
namespace {

constexpr const char* kBall = "builtin:buckyball --volume-size 64 --size 128x128 -o ";

TEST(PlanOptions, ReadsSharesAndDurations) {
  EXPECT_DOUBLE_EQ(parse_share("--max-error", "1%"), 0.01);
  EXPECT_DOUBLE_EQ(parse_share("--max-error", "0.25"), 0.25);
  EXPECT_EQ(parse_duration("--time-budget", "20ms"), 20'000'000'000u);
  EXPECT_EQ(parse_duration("--time-budget", "1.5s"), 1'500'000'000'000u);
  for (const char* text : {"", "0", "-1%", "101%", "1 %", "nan", "1percent"}) {
    EXPECT_THROW(parse_share("--max-error", text), CLI::ValidationError) << text;
  }
  for (const char* text : {"", "20", "0ms", "-1s", "inf s", "1h", "1e30s"}) {
    EXPECT_THROW(parse_duration("--time-budget", text), CLI::ValidationError) << text;
  }
}

TEST_F(RenderProgram, PlansForAnErrorAndExplainsItself) {
  const ProgramResult result = run(kBall + path("ball.png") + " --max-error 2% --explain --stats " + path("ball.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("plan for an error of at most 2%"), HasSubstr("level of detail 0"),
                                HasSubstr("sampling: "), HasSubstr("error: "), HasSubstr("cost: ")));
  const auto json = nlohmann::json::parse(text_of(path("ball.json")));
  const auto &plan = json.at("plan"), &chosen = plan.at("chosen"), &finest = plan.at("finest");
  EXPECT_LE(chosen.at("error_bound").get<double>(), 0.02);
  EXPECT_NEAR(chosen.at("samples").get<double>(), json.at("samples").get<double>(),
              0.1 * json.at("samples").get<double>());
  EXPECT_GT(finest.at("samples").get<double>(), 3 * chosen.at("samples").get<double>());
  EXPECT_GT(plan.at("points").size(), 4u);
}

TEST_F(RenderProgram, KeepsATimeBudgetOnABoardThatKeepsTime) {
  const ProgramResult result = run(kBall + path("ball.png") + " --time-budget 6ms --stats " + path("ball.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(text_of(path("ball.json")));
  EXPECT_EQ(json.at("fidelity"), "cycle");
  EXPECT_LE(json.at("frame_ms").get<double>(), 6);
  EXPECT_TRUE(json.at("plan").at("kept").get<bool>());
}

TEST_F(RenderProgram, PlansForACycleBoardWhatItPlansForAFunctionalOne) {
  for (const char* level : {"cycle", "functional"}) {
    const ProgramResult result = run(
        std::string("builtin:buckyball --volume-size 32 --size 48x48 --no-shade --max-error 20% --quiet -o ") +
        path(std::string(level) + ".png") + " --fidelity " + level + " --stats " + path(std::string(level) + ".json"));
    ASSERT_EQ(result.code, 0) << result.err;
  }
  const auto plan_of = [&](const char* level) {
    return nlohmann::json::parse(text_of(path(std::string(level) + ".json"))).at("plan").at("finest").at("samples");
  };
  EXPECT_EQ(plan_of("cycle"), plan_of("functional"));
}

TEST_F(RenderProgram, PlansALitSceneWithItsLight) {
  const ProgramResult result = run(GICUBE_SOURCE_DIR
                                   "/samples/scenes/golden_ring.scene --volume-size 24 --size 64x64 --max-error 20% "
                                   "--explain -o " +
                                   path("ring.png") + " --stats " + path("ring.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(text_of(path("ring.json")));
  const auto& plan = json.at("plan");
  EXPECT_GT(plan.at("finest").at("samples").get<double>(), 3 * plan.at("chosen").at("samples").get<double>());
  ASSERT_EQ(plan.at("light").size(), 3u);  // colour passes
  for (std::size_t i = 0; i < 3; ++i) {
    const auto light = plan.at("light").at(i), pass = json.at("lighting").at(i);
    EXPECT_EQ(light.at("channel"), i);
    EXPECT_NEAR(light.at("max_error").get<double>(), 0.2 / std::sqrt(2.0), 1e-9);
    EXPECT_LE(light.at("chosen").at("error_bound").get<double>(), 0.2 / std::sqrt(2.0));
    EXPECT_EQ(light.at("chosen").at("rays_per_face_voxel"), pass.at("rays_per_face_voxel"));
    EXPECT_LT(pass.at("rays_per_face_voxel").get<int>(), 32);  // which the scene asks for
  }
  EXPECT_THAT(result.out, AllOf(HasSubstr("plan of light and picture for an error of at most 20%"),
                                HasSubstr("plan of the light in green"), HasSubstr("plan of the picture")));
}

// What the plan says of the picture is what one took, and light and picture together keep the budget.
TEST_F(RenderProgram, KeepsATimeBudgetOfLightAndPicture) {
  constexpr std::pair<const char*, double> kScenes[] = {// ms
                                                        {"fog_box", 60},
                                                        {"glass", 150},
                                                        {"golden_ring", 120}};
  for (const auto& [scene, budget] : kScenes) {
    const ProgramResult result =
        run(fmt::format(GICUBE_SOURCE_DIR "/samples/scenes/{}.scene --volume-size 24 "
                                          "--size 96x96 --time-budget {}ms --quiet -o {} --stats {}",
                        scene, budget, path("lit.png"), path("lit.json")));
    ASSERT_EQ(result.code, 0) << result.err;
    const auto json = nlohmann::json::parse(text_of(path("lit.json")));
    EXPECT_EQ(json.at("fidelity"), "cycle") << scene;
    const auto& plan = json.at("plan");
    EXPECT_TRUE(plan.at("kept").get<bool>()) << scene;
    const double frame = json.at("frame_ms").get<double>();
    double all = frame;
    for (const auto& pass : json.at("lighting")) all += pass.at("pass_ms").get<double>();
    EXPECT_LE(all, budget) << scene;
    const double planned =
        plan.at("chosen").at("frame_ms").get<double>() * static_cast<double>(json.at("lighting").size());
    EXPECT_NEAR(planned, frame, 0.02 * frame) << scene;
  }
}

// Rays begin at the part's faces, so that samples lie elsewhere: nearly the same picture, of fewer samples.
TEST_F(RenderProgram, LoadsOnlyWhatShowsIfAsked) {
  const std::string scene = "builtin:buckyball --volume-size 64 --size 64x64 --cut 0,0,1,0 --quiet -o ";
  ASSERT_EQ(run(scene + path("whole.png") + " --stats " + path("whole.json")).code, 0);
  const ProgramResult part = run(scene + path("part.png") + " --crop --stats " + path("part.json"));
  ASSERT_EQ(part.code, 0) << part.err;
  const auto number = [&](const char* file, const char* key) {
    return nlohmann::json::parse(text_of(path(file))).at(key).get<double>();
  };
  EXPECT_LE(number("part.json", "samples"), number("whole.json", "samples"));
  EXPECT_LE(number("part.json", "load_ms"), number("whole.json", "load_ms"));
  for (const int at : {20, 32, 40}) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(pixel(path("part.png"), at, 32)[c], pixel(path("whole.png"), at, 32)[c], 0.15) << at;
    }
  }
  EXPECT_EQ(run(GICUBE_SOURCE_DIR "/samples/scenes/fog_box.scene --volume-size 16 --crop -o " + path("x.png")).code, 2);
}

// Eight times fewer voxels to load, half as many samples a ray, and nearly the same picture; with the part that shows
// as well.
TEST_F(RenderProgram, LoadsACoarserVolumeIfAsked) {
  const std::string scene = "builtin:buckyball --volume-size 128 --size 64x64 --no-leap --quiet -o ";
  ASSERT_EQ(run(scene + path("fine.png") + " --stats " + path("fine.json")).code, 0);
  const auto number = [&](const char* file, const char* key) {
    return nlohmann::json::parse(text_of(path(file))).at(key).get<double>();
  };
  for (const char* crop : {"", " --crop"}) {
    const ProgramResult coarse =
        run(scene + path("coarse.png") + " --level-of-detail 1" + crop + " --stats " + path("coarse.json"));
    ASSERT_EQ(coarse.code, 0) << coarse.err;
    EXPECT_NEAR(number("coarse.json", "samples") / number("fine.json", "samples"), 0.5, 0.05) << crop;
    EXPECT_LT(number("coarse.json", "load_ms"), 0.25 * number("fine.json", "load_ms"));
    double difference = 0;
    for (int y = 0; y < 64; y += 7) {
      for (int x = 0; x < 64; x += 7) {
        const auto a = pixel(path("coarse.png"), x, y), b = pixel(path("fine.png"), x, y);
        for (std::size_t c = 0; c < 3; ++c) difference += std::abs(double{a[c]} - double{b[c]}) / (3 * 100);
      }
    }
    EXPECT_LT(difference, 0.02) << crop;
    EXPECT_GT(difference, 0) << crop;
  }
  EXPECT_EQ(run(scene + path("x.png") + " --level-of-detail 1 --max-error 1%").code, 2);
  const ProgramResult nothing = run("builtin:buckyball --volume-size 32 --level-of-detail 6 -o " + path("x.png"));
  EXPECT_EQ(nothing.code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("level"));
}

TEST_F(RenderProgram, RefusesPlansThatContradictOtherOptions) {
  const std::string begin = kBall + path("ball.png");
  for (const char* wrong : {" --max-error 1% --time-budget 5ms", " --explain", " --max-error 1% --step 1",
                            " --time-budget 5ms --threshold 0.5", " --max-error 1% --illumination low --light-rays 4",
                            " --max-error 0", " --time-budget 5"}) {
    EXPECT_EQ(run(begin + wrong).code, 2) << wrong;
  }
}

}  // namespace
}  // namespace gicube::samples
