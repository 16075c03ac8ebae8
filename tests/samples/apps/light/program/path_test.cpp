// The program itself, with a private emulated board.
#include <nlohmann/json.hpp>

#include "program_test.h"
#include "scene/names.h"
#include "test.h"

namespace gicube::samples {
namespace {

class PathProgram : public ProgramTest {
 protected:
  PathProgram() : ProgramTest("gicube-light path") {}
};

TEST_F(PathProgram, MakesAPictureWithItsNoiseAndItsCost) {
  const ProgramResult result = run("builtin:buckyball --volume-size 24 --size 12x8 --passes 3 -o " + path("x.png") +
                                   " --pixels " + path("x.csv") + " --stats " + path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("288 paths"), HasSubstr("mean radiance"), HasSubstr("simulated")));
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  EXPECT_EQ(json.at("paths"), 288);
  EXPECT_GT(json.at("rays").get<int>(), 288);
  EXPECT_GT(json.at("relative_error").get<double>(), 0);
  EXPECT_GT(json.at("board_ms").get<double>(), 0);
  std::ifstream csv(path("x.csv"));
  std::string line;
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  EXPECT_EQ(lines, 1 + 96);
  EXPECT_TRUE(text_of(path("x.png")).starts_with("\x89PNG"));
}

TEST_F(PathProgram, MakesTheSameLightWithACardThatDoesNotStoreTheVolume) {
  std::vector<std::string> pictures;
  for (const char* card : {"64", "32"}) {
    const ProgramResult result = run("builtin:buckyball --volume-size 40 --size 8x6 --passes 1 --pixels " +
                                     path("x.csv") + " --set asic.block_voxels=8 --set asic.max_volume_voxels=" + card);
    ASSERT_EQ(result.code, 0) << result.err;
    pictures.push_back(text_of(path("x.csv")));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

TEST_F(PathProgram, MakesTheSameLightAtEveryLevelAndWithAnyThreads) {
  std::vector<std::string> pictures;
  for (const char* how :
       {"--fidelity functional --threads 1", "--fidelity functional --threads 2", "--fidelity cycle"}) {
    const ProgramResult result =
        run("builtin:buckyball --volume-size 16 --size 8x6 --passes 1 --pixels " + path("x.csv") + " " + how);
    ASSERT_EQ(result.code, 0) << result.err;
    pictures.push_back(text_of(path("x.csv")));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST_F(PathProgram, SaysWhatItCantDo) {
  const auto refused = [&](const std::string& arguments, int code, const std::string& text) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments;
    EXPECT_THAT(result.err, HasSubstr(text)) << arguments;
  };
  refused("builtin:buckyball --passes 0", 2, "--passes");
  refused("builtin:buckyball -o x.jpg", 2, "--output: expected a name that ends in .png or .exr, got \"x.jpg\"");
  const auto scene = [&](const std::string& text) {
    std::ofstream(path("x.scene")) << "world { size: 8 node { material: \"a\" sphere { radius: 0.5 } } } " << text;
    return path("x.scene");
  };
  const std::string lit = "light { point { position { z: 3 } } power: 1 }";
  refused(scene(lit + "material { name: \"a\" solid { } scattering: 0.5 bsdf: \"dull_reflection\" gloss: 0.2 }"), 1,
          "material of tag 0.bsdf: expected none, isotropic, diffuse, specular or trap, got a dull one");
  refused(scene(lit + "material { name: \"a\" solid { } } cut_plane { normal { z: 1 } offset: 0 }"), 1,
          "cut_plane: expected none, got 1");
  refused(scene(lit + "material { name: \"a\" solid { } } camera { orthographic_height: 9 }"), 1,
          "camera.orthographic_height: expected a perspective camera");
}

}  // namespace
}  // namespace gicube::samples
