// Global illumination as it is seen in pictures of gicube-render: the shipped scenes and small ones of their kind.
#include <nlohmann/json.hpp>

#include "render_program.h"
#include "test.h"

namespace gicube::samples {
namespace {

class LitScenes : public RenderProgram {
 protected:
  // Draws a scene's text in 40 x 40 pixels; the picture's path.
  std::string draw(const std::string& name, const std::string& text, const std::string& options = "") const {
    std::ofstream(path(name + ".scene")) << text;
    const ProgramResult result =
        run(path(name + ".scene") + " --size 40x40 --set asic.datapath=wide -o " + path(name + ".png") + " " + options);
    EXPECT_EQ(result.code, 0) << result.err;
    return path(name + ".png");
  }

  // Seen from straight above: a floor, and what else is there.
  static std::string from_above(const std::string& floor, const std::string& rest) {
    return R"(world { low { x: -1 y: -1 z: 0 } high { x: 1 y: 1 z: 1 } size: 40
                node { material: "floor" box { low { x: -2 y: -2 z: -1 } high { x: 2 y: 2 z: 0.15 } } } )" +
           rest + R"(phong { ambient: 0 diffuse: 1 specular: 0 } background { red: 0 green: 0 blue: 0 }
              camera { eye { z: 9 } look_at { z: 0 } up { y: 1 } orthographic_height: 2 }
              material { name: "floor" solid { opacity: 0.5 } )" +
           floor + " }\n";
  }
};

TEST_F(LitScenes, OfTheSourceTreeAreDrawn) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GICUBE_SOURCE_DIR "/samples/scenes")) {
    if (entry.path().extension() != ".scene") continue;
    std::ifstream file(entry.path());
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    if (text.find("illumination {") == std::string::npos) continue;
    ++scenes;
    const std::string picture = path(entry.path().stem().string() + ".png");
    const ProgramResult result = run(
        entry.path().string() + " --volume-size 32 --size 32x32 --samples 1 --light-rays 2 --lifetime 4 -o " + picture);
    EXPECT_EQ(result.code, 0) << entry.path() << result.err;
    EXPECT_GT(colours(picture, 32, 32), 50u) << entry.path();
    EXPECT_THAT(result.out, HasSubstr("escaped"));
  }
  EXPECT_GE(scenes, 7);
}

TEST_F(LitScenes, HaveAHardShadowOfAPointLightAndASoftOneOfABall) {
  const auto scene = [](const std::string& light) {
    return from_above("", R"(node { material: "ball" transform { translate { z: 0.7 } } sphere { radius: 0.25 } } }
                             material { name: "ball" solid { } }
                             illumination { rays_per_face_voxel: 32 } light { power: 300 )" +
                              light + "}");
  };
  // The ball's shadow falls on x = +0.55, which is pixel 31; pixel 20 is the ball itself.
  const auto shadow = [](const std::string& picture) { return pixel(picture, 31, 20)[0] / pixel(picture, 5, 20)[0]; };
  const float hard = shadow(draw("hard", scene("point { position { x: -4 z: 4.7 } } ")));
  const float soft = shadow(draw("soft", scene("sphere { centre { x: -4 z: 4.7 } radius: 2.5 } ")));
  EXPECT_LT(hard, 0.2);
  EXPECT_GT(soft, hard + 0.15);
  EXPECT_LT(soft, 0.9);
}

TEST_F(LitScenes, ShowInAMirrorWhatStandsBeforeIt) {
  const auto scene = [](const std::string& scattering) {
    return R"(world { low { x: -1 y: -1 z: 0 } high { x: 1 y: 1 z: 1 } size: 40
        node { material: "mirror" box { low { x: -2 y: 0.8 z: -1 } high { x: 2 y: 3 z: 3 } } }
        node { material: "red" transform { translate { y: 0.2 z: 0.5 } } sphere { radius: 0.25 } } }
      material { name: "mirror" solid { colour { red: 0 green: 0 blue: 0 } } bsdf: "specular" scattering: )" +
           scattering + R"( seen_through_scattering: true }
      material { name: "red" solid { opacity: 0.5 colour { red: 1 green: 0.1 blue: 0.1 } } }
      light { point { position { x: 1 y: 4 z: 3 } } power: 100 } light { point { position { y: -4 z: 3 } } power: 200 }
      illumination { rays_per_face_voxel: 4 } phong { ambient: 0.3 diffuse: 0.7 specular: 0 }
      background { red: 0 green: 0 blue: 0 }
      camera { eye { x: -2.2 y: -1.8 z: 0.5 } look_at { x: 0.2 y: 0.8 z: 0.5 } up { z: 1 } fov_degrees: 40 })";
  };
  const auto red_columns = [](const std::string& picture) {
    int blobs = 0;
    bool inside = false;
    for (int x = 0; x < 40; ++x) {
      const auto colour = pixel(picture, x, 20);
      const bool red = colour[0] > 0.1f && colour[0] > 2 * colour[1];
      blobs += red && !inside ? 1 : 0;
      inside = red;
    }
    return blobs;
  };
  EXPECT_EQ(red_columns(draw("black", scene("0"))), 1);
  EXPECT_GE(red_columns(draw("mirror", scene("0.95"))), 2);
}

TEST_F(LitScenes, BleedInColourPassesOnly) {
  const std::string rest = R"(node { material: "wall" box { low { x: 0.7 y: -2 z: -1 } high { x: 3 y: 2 z: 3 } } } }
      material { name: "wall" solid { opacity: 0.5 colour { red: 1 green: 0.1 blue: 0.1 } } bsdf: "diffuse"
        scattering: 0.8
                 scattering_colour { red: 1 green: 0.1 blue: 0.1 } }
      light { towards { x: -1 z: 0.4 } power: 1 } illumination { rays_per_face_voxel: 16 exposure: 1 colour_passes: )";
  const auto grey = pixel(draw("grey", from_above("", rest + "false }")), 30, 20);
  const auto red = pixel(draw("red", from_above("", rest + "true }")), 30, 20);
  EXPECT_NEAR(grey[0], grey[1], 0.01);
  EXPECT_GT(red[0], red[1] + 0.03f);
}

TEST_F(LitScenes, KeepTheLightWhileTheEyeMoves) {
  const std::string scene = from_above("", R"(} light { point { position { z: 4 } } power: 100 } illumination { }
      engine { target: "camera.eye.x" rate: 4 })");
  draw("move", scene, "--frames 3 --duration 3 --stats " + path("move.json"));
  const auto json = nlohmann::json::parse(text_of(path("move.json")));
  EXPECT_EQ(json.at("illumination_passes"), 1);
  EXPECT_EQ(json.at("volumes_loaded"), 1);
  ASSERT_EQ(json.at("frames").size(), 3u);
  EXPECT_EQ(json.at("frames").at(0).at("lighting").at(0).at("reused"), false);
  EXPECT_EQ(json.at("frames").at(2).at("lighting").at(0).at("reused"), true);
  EXPECT_EQ(json.at("frames").at(2).at("time"), 2);
  EXPECT_NE(pixels_of(path("move_0000.png")), pixels_of(path("move_0002.png")));
  // A single picture of that time is the same.
  draw("alone", scene, "--time 2");
  EXPECT_EQ(pixels_of(path("alone.png")), pixels_of(path("move_0002.png")));
}

TEST_F(LitScenes, AreLitAnewWhenALightOrASolidMoves) {
  const std::string light = "} light { name: \"l\" point { position { z: 4 } } power: 100 } illumination { } ";
  draw("light", from_above("", light + "engine { target: \"light[l].position.x\" rate: 1 }"),
       "--frames 2 --stats " + path("light.json"));
  const auto moved_light = nlohmann::json::parse(text_of(path("light.json")));
  EXPECT_EQ(moved_light.at("illumination_passes"), 2);
  EXPECT_EQ(moved_light.at("volumes_loaded"), 1);
  const std::string ball =
      "node { name: \"b\" material: \"floor\" transform { translate { z: 0.5 } } sphere { radius: 0.2 } } ";
  draw("solid", from_above("", ball + light + "engine { target: \"node[b].transform[0].translate.x\" rate: 1 }"),
       "--frames 2 --stats " + path("solid.json"));
  const auto moved_solid = nlohmann::json::parse(text_of(path("solid.json")));
  EXPECT_EQ(moved_solid.at("illumination_passes"), 2);
  EXPECT_EQ(moved_solid.at("volumes_loaded"), 2);
}

TEST_F(LitScenes, OfPlainVolumesHaveALightOfTheirOwn) {
  const std::string ball = "builtin:buckyball --volume-size 40 --size 40x40 --quiet -o ";
  ASSERT_EQ(run(ball + path("plain.png")).code, 0);
  const ProgramResult lit =
      run(ball + path("lit.png") + " --illumination low --light-rays 4 --stats " + path("lit.json"));
  ASSERT_EQ(lit.code, 0) << lit.err;
  EXPECT_GT(colours(path("lit.png"), 40, 40), 100u);
  EXPECT_NE(pixels_of(path("plain.png")), pixels_of(path("lit.png")));
  const auto json = nlohmann::json::parse(text_of(path("lit.json"))).at("lighting").at(0);
  const double emitted = json.at("emitted").get<double>();
  EXPECT_GT(emitted, 0);
  EXPECT_NEAR(json.at("deposited").get<double>() + json.at("escaped").get<double>() +
                  json.at("scattered_away").get<double>() + json.at("clipped").get<double>(),
              emitted, 1e-9 * emitted);
}

TEST_F(LitScenes, ThatCannotBeAreRefusedByField) {
  const std::pair<std::string, const char*> cases[] = {
      {from_above("bsdf: \"diffuse\" scattering: 1.5", "}"), "material[floor].scattering: expected 0 to 1, got 1.5"},
      {from_above("", "} light { name: \"l\" rectangle { edge_u { x: 1 } edge_v { x: 1 } } }"),
       "light[l].rectangle.edge_v"},
      {from_above("", "node { name: \"m\" material: \"floor\" mesh { file: \"none.ply\" } } }"), "node[m]"}};
  for (const auto& [text, fault] : cases) {
    std::ofstream(path("bad.scene")) << text;
    const ProgramResult result = run(path("bad.scene") + " -o " + path("bad.png"));
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, HasSubstr(fault));
    EXPECT_FALSE(std::filesystem::exists(path("bad.png")));
  }
}

}  // namespace
}  // namespace gicube::samples
