// Plans of light on scenes that plan_light() was not written with: the measured error stays under the bound.
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>

#include "lit_study.h"

namespace gicube::plan_study {
namespace {

constexpr int kSize = 192;  // pixels

class HeldOutLight : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1); }

  static LitScene scene(const std::string& name) {
    for (const LitScene& lit : lit_scenes(GICUBE_SOURCE_DIR "/../shared/data", GICUBE_SOURCE_DIR)) {
      if (lit.study.name == name) return lit;
    }
    throw std::runtime_error("no lit scene of that name: " + name);
  }
};

TEST_P(HeldOutLight, TheMeasuredErrorsStayUnderTheirBounds) {
  const LitScene lit = scene(GetParam());
  ASSERT_GT(lit.study.batch, 0);
  if (!lit.study.available()) GTEST_SKIP() << "needs " << lit.study.scene.volume.file.string();
  const LitOutcome outcome = carry_out_lit(lit, kSize, "emu:?fidelity=functional");
  const LightPoint& light = outcome.light.chosen;
  if (outcome.light.kept) {
    EXPECT_LE(light.error_bound, share_of_light(lit.max_error));
    EXPECT_LE(outcome.bound, lit.max_error);
  } else {
    EXPECT_TRUE(outcome.light.at_limit || light.rays_per_face_voxel == 256);  // more than which are never chosen
  }
  EXPECT_LE(outcome.light_error, light.error_bound);
  EXPECT_LE(outcome.error, outcome.bound);
  EXPECT_LT(outcome.reference_noise, 0.5 * light.error_bound);  // else nothing was measured
  EXPECT_GT(outcome.light_error, 0.3 * light.error);            // nor is the bound what nothing comes near
}

// The others take minutes: gicube-plan-study --lit has all.
INSTANTIATE_TEST_SUITE_P(Scenes, HeldOutLight, testing::Values("mirror and ball", "glass, 20%", "ball", "T1"),
                         [](const auto& name) {
                           std::string text;
                           for (const char* c = name.param; *c != 0; ++c) {
                             if (std::isalnum(static_cast<unsigned char>(*c)) != 0) text += *c;
                           }
                           return text;
                         });

}  // namespace
}  // namespace gicube::plan_study
