// --max-error 1% on scenes that make_plan() was not written with: the measured error stays under the bound, and the
// cost falls at least three times. And plans for several errors over real scans take the cheapest setting that they
// found.
#include <cctype>

#include "study.h"
#include "test.h"

namespace gicube::plan_study {
namespace {

constexpr int kSize = 192;  // pixels: a whole picture at the finest setting is what takes long here

std::string words_of(const char* name) {
  std::string text;
  for (; *name != 0; ++name) {
    if (std::isalnum(static_cast<unsigned char>(*name)) != 0) text += *name;
  }
  return text;
}

class HeldOut : public testing::TestWithParam<const char*> {
 protected:
  static StudyScene scene(const std::string& name) {
    for (const StudyScene& study : study_scenes(GICUBE_SOURCE_DIR "/../shared/data", GICUBE_SOURCE_DIR)) {
      if (study.name == name) return study;
    }
    throw std::runtime_error("no scene of that name: " + name);
  }
};

TEST_P(HeldOut, TheMeasuredErrorStaysUnderTheBoundAndTheCostFallsThreeTimes) {
  const StudyScene study = scene(GetParam());
  ASSERT_GT(study.batch, 0);
  if (!study.available()) GTEST_SKIP() << "needs " << study.scene.volume.file.string();
  const PlanOutcome outcome = carry_out(study, kSize, {.max_error = 0.01}, "emu:?fidelity=functional");
  EXPECT_LE(outcome.plan.chosen.error_bound, 0.01);
  EXPECT_LE(outcome.error, outcome.plan.chosen.error_bound);
  EXPECT_TRUE(outcome.error > 0 || outcome.plan.chosen.step == outcome.plan.best.step);  // else nothing was compared
  EXPECT_LE(3 * outcome.chosen.samples, outcome.finest.samples);
  // The plan's cost is the measured one.
  EXPECT_NEAR(outcome.plan.chosen.samples, outcome.chosen.samples, 0.1 * outcome.chosen.samples);
}

class Scans : public HeldOut {};

TEST_P(Scans, EveryPlanTakesTheCheapestSettingWhoseBoundKeepsTheTarget) {
  const StudyScene study = scene(GetParam());
  if (!study.available()) GTEST_SKIP() << "needs " << study.scene.volume.file.string();
  std::optional<PlanPoint> before;
  for (const Plan& plan : plans_for(study, 96, {0.005, 0.01, 0.02, 0.03, 0.05}, "emu:?fidelity=functional")) {
    SCOPED_TRACE(testing::Message() << "error " << plan.request.max_error << ", level " << plan.chosen.level
                                    << ", step " << plan.chosen.step << ", threshold " << plan.chosen.opacity_threshold
                                    << ", pilot of " << plan.chosen.pilot_width << ", " << plan.chosen.samples
                                    << " samples");
    EXPECT_TRUE(plan.kept);
    EXPECT_LE(plan.chosen.error_bound, plan.request.max_error);
    EXPECT_EQ(cheaper_and_kept(plan), 0);
    // Costs are predicted, by pilots whose sizes differ. A setting that is no finer in any respect takes no more
    // samples of any ray, whatever its pilot predicts.
    const bool is_no_finer = before && plan.chosen.level >= before->level && plan.chosen.step >= before->step &&
                             plan.chosen.opacity_threshold <= before->opacity_threshold;
    if (before && !is_no_finer) {
      EXPECT_LE(plan.chosen.samples, before->samples);
    }
    before = plan.chosen;
  }
}

INSTANTIATE_TEST_SUITE_P(Scans, Scans, testing::Values("engine", "mouse", "T1", "FLAIR, not shaded", "mouse, ramp"),
                         [](const auto& name) { return words_of(name.param); });

INSTANTIATE_TEST_SUITE_P(Scenes, HeldOut,
                         testing::Values("mouse", "T1", "FLAIR, not shaded", "head, bone", "head, skin",
                                         "ball, cut, from near", "ball, far away", "subsurface", "T2",
                                         "head from behind", "mouse, ramp", "engine, cut", "small ball, magnified",
                                         "fog box", "golden ring"),
                         [](const auto& name) { return words_of(name.param); });

}  // namespace
}  // namespace gicube::plan_study
