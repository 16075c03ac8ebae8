// The program itself, with a private emulated board.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "program_test.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;

class SubsurfaceProgram : public ProgramTest {
 protected:
  SubsurfaceProgram() : ProgramTest("gicube-subsurface") {}
  std::string scenes() const {
    std::ofstream(path("slab.scene")) << R"(world { size: 17 low { } high { x: 2 y: 2 z: 1 }
        node { material: "milk" box { low { x: -9 y: -9 z: -9 } high { x: 9 y: 9 z: 9 } } } }
      material { name: "milk" fog { extinction: 8 } scattering: 0.9 bsdf: "isotropic" })";
    std::ofstream(path("x.scene"))
        << R"(world { size: 16 node { name: "cube" material: "white" box { low { x: -0.5 y: -0.5 z: -0.5 } high { x: 0.5 y: 0.5 z: 0.5 } } } }
      material { name: "white" solid { } scattering: 0.7 bsdf: "diffuse" }
      light { point { position { x: -2 y: -3 z: 3 } } power: 100 })";
    return path("x.scene") + " --material " + path("slab.scene");
  }
};

TEST_F(SubsurfaceProgram, MeasuresAProfileAndDrawsAMeshThatHasIt) {
  const ProgramResult result = run(scenes() + " --photons 5000 --rings 8 --passes 2 --size 16x12 -o " + path("x.png") +
                                   " --profile " + path("p.csv") + " --stats " + path("x.json"));
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, testing::AllOf(HasSubstr("5000 photons"), HasSubstr("comes back"), HasSubstr("simulated")));
  const auto json = nlohmann::json::parse(text_of(path("x.json")));
  const double reflected = json.at("reflected")[0].get<double>();
  EXPECT_GT(reflected, 0.3);
  EXPECT_LT(reflected, 0.6);
  EXPECT_THAT(result.out, HasSubstr("(standard errors)"));
  for (const char* part :
       {"reflected", "transmitted", "sideways"}) {  // an albedo below 1: at most that of shares of photons
    const double share = json.at(part)[0].get<double>(), error = json.at(part + std::string("_error"))[0].get<double>();
    EXPECT_GT(share, 0) << part;
    EXPECT_GT(error, 0) << part;
    EXPECT_LE(error, std::sqrt(share * (1 - share) / 5000)) << part;
  }
  std::ifstream csv(path("p.csv"));
  std::string line;
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  EXPECT_EQ(lines, 1 + 8);
  EXPECT_TRUE(text_of(path("x.png")).starts_with("\x89PNG"));
}

TEST_F(SubsurfaceProgram, MakesTheSameLightAtEveryLevelAndWithAnyThreads) {
  std::vector<std::string> pictures;
  for (const char* how :
       {"--fidelity functional --threads 1", "--fidelity functional --threads 2", "--fidelity cycle"}) {
    const ProgramResult result = run(scenes() + " --photons 1000 --rings 4 --passes 1 --size 8x6 --profile " +
                                     path("p.csv") + " --pixels " + path("x.csv") + " " + how);
    ASSERT_EQ(result.code, 0) << result.err;
    pictures.push_back(text_of(path("x.csv")) + text_of(path("p.csv")));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST_F(SubsurfaceProgram, SaysWhatItCantDo) {
  const ProgramResult none = run("x.scene");
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("--material"));
  const ProgramResult node = run(scenes() + " --node ball");
  EXPECT_EQ(node.code, 2);
  EXPECT_THAT(node.err, HasSubstr("--node: expected a node of boxes or meshes, got \"ball\""));
}

}  // namespace
}  // namespace gicube::samples
