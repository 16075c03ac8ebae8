// The program itself, with a private emulated board.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "program_test.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;

class PolygonGiProgram : public ProgramTest {
 protected:
  PolygonGiProgram() : ProgramTest("gicube-polygon-gi") {}
  std::string scene() const {
    std::ofstream(path("x.scene")) << R"(world { size: 16
      node { material: "lamp" box { low { x: -0.4 y: -0.4 z: 0.9 } high { x: 0.4 y: 0.4 z: 1 } } }
      node { material: "white" box { low { x: -1 y: -1 z: -1.1 } high { x: 1 y: 1 z: -1 } } }
      node { material: "fog" box { } } }
      material { name: "lamp" solid { } emission: 3 }
      material { name: "white" solid { } scattering: 0.7 bsdf: "diffuse" }
      material { name: "fog" fog { extinction: 0.5 } scattering: 0.8 bsdf: "isotropic" })";
    return path("x.scene");
  }
};

TEST_F(PolygonGiProgram, MakesAPictureAndTellsWhereTheLightGoes) {
  const ProgramResult result = run(scene() + " --edge 8 --zone 8 --rays 200 --passes 4 --size 12x8 -o " +
                                   path("x.png") + " --pixels " + path("x.csv") + " --stats " + path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, testing::AllOf(HasSubstr("sides of triangles"), HasSubstr("8 zones"), HasSubstr("escaped"),
                                         HasSubstr("mean radiance"), HasSubstr("simulated")));
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  EXPECT_EQ(json.at("zones"), 8);
  EXPECT_NEAR(json.at("emitted")[0].get<double>(), 3 * (2 * 0.64 + 4 * 0.08), 1e-6);  // in the scene's units
  const double emitted = json.at("emitted")[0].get<double>();
  double all = 0;
  for (const char* where : {"absorbed_by_surfaces", "absorbed_by_medium", "escaped"})
    all += json.at(where)[0].get<double>();
  EXPECT_NEAR(all, emitted, 0.05 * emitted);
  EXPECT_TRUE(text_of(path("x.png")).starts_with("\x89PNG"));
}

// As in gicube-path and gicube-photon-map: on a square of the voxel's edge, here 2/15, a radiosity of 3 is 3 (2/15)^2 of power.
TEST_F(PolygonGiProgram, WritesRadiancesInTheUnitOfAllProgramsOfPaths) {
  std::ofstream(path("x.scene")) << R"(world { size: 16
      node { material: "lamp" box { low { x: -0.9 y: 0.4 z: -0.9 } high { x: 0.9 y: 0.8 z: 0.9 } } }
      node { material: "fog" box { high { x: -0.95 } } } }
      material { name: "lamp" solid { } emission: 3 }
      material { name: "fog" fog { extinction: 0.5 } bsdf: "isotropic" }
      camera { eye { y: -3 } look_at { } fov_degrees: 5 })";
  const ProgramResult result =
      run(path("x.scene") + " --edge 8 --zone 8 --rays 16 --passes 2 --size 4x4 --pixels " + path("x.csv"));
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream csv(text_of(path("x.csv")));
  std::string line;
  std::getline(csv, line);
  int pixels = 0;
  for (; std::getline(csv, line); ++pixels) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream numbers(line);
    double x = 0, y = 0, red = 0;
    numbers >> x >> y >> red;
    EXPECT_NEAR(red, 3 / std::numbers::pi * 4 / 225, 1e-6);
  }
  EXPECT_EQ(pixels, 16);
}

TEST_F(PolygonGiProgram, MakesTheSameLightAtEveryLevelAndWithAnyThreads) {
  std::vector<std::string> pictures;
  for (const char* how :
       {"--fidelity functional --threads 1", "--fidelity functional --threads 2", "--fidelity cycle"}) {
    const ProgramResult result =
        run(scene() + " --edge 8 --zone 8 --rays 30 --passes 1 --size 8x6 --pixels " + path("x.csv") + " " + how);
    ASSERT_EQ(result.code, 0) << result.err;
    pictures.push_back(text_of(path("x.csv")));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST_F(PolygonGiProgram, SaysWhatItCantDo) {
  const ProgramResult none = run("builtin:buckyball");
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("world: expected one with solids, got none"));
  const ProgramResult edge = run(scene() + " --edge 0");
  EXPECT_EQ(edge.code, 2);
  EXPECT_THAT(edge.err, HasSubstr("--edge"));
}

}  // namespace
}  // namespace gicube::samples
