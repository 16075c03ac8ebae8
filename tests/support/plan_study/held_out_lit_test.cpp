// Plans of light on scenes that plan_light() was not written with: the measured error stays under the bound.
#include <cctype>

#include "gicube/level_of_detail.h"
#include "gicube/scene/volume_file.h"
#include "lit_study.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::plan_study {
namespace {

constexpr int kSize = 192;  // pixels

class HeldOutLight : public testing::TestWithParam<const char*> {
 protected:
  static LitScene scene(const std::string& name) {
    for (const LitScene& lit : lit_scenes(GICUBE_SOURCE_DIR "/../shared/data", GICUBE_SOURCE_DIR)) {
      if (lit.study.name == name) return lit;
    }
    throw std::runtime_error("no lit scene of that name: " + name);
  }

  // The scan with one voxel for eight.
  void halve(LitScene& lit) const {
    std::filesystem::path& file = lit.study.scene.volume.file;
    const DerivedVolume half = coarser(samples::read_volume(file).view(), 1);
    std::vector<float> values(half.samples.size() / sizeof(float));
    std::memcpy(values.data(), half.samples.data(), half.samples.size());
    file = folder_.file("halved.nrrd");
    samples::write_volume({half.dims, half.spacing, {}, values}, file);
  }

 private:
  reference::TemporaryDirectory folder_;
};

TEST_P(HeldOutLight, TheMeasuredErrorsStayUnderTheirBounds) {
  const std::string name = GetParam(), halved = ", halved";
  LitScene lit = scene(name.substr(0, name.find(halved)));
  ASSERT_GT(lit.study.batch, 0);
  if (!lit.study.available()) GTEST_SKIP() << "needs " << lit.study.scene.volume.file.string();
  if (name.ends_with(halved)) halve(lit);
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

// The others, and the whole scan, take minutes: gicube-plan-study --lit has all.
INSTANTIATE_TEST_SUITE_P(Scenes, HeldOutLight, testing::Values("mirror and ball", "glass, 20%", "ball", "T1, halved"),
                         [](const auto& name) {
                           std::string text;
                           for (const char* c = name.param; *c != 0; ++c) {
                             if (std::isalnum(static_cast<unsigned char>(*c)) != 0) text += *c;
                           }
                           return text;
                         });

}  // namespace
}  // namespace gicube::plan_study
