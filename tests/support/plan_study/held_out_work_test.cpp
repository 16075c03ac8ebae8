// Plans of radiosity and of filtered backprojection on what they were not written with: the measured error stays under
// the bound. gicube-plan-study --radiosity and --fdk have more of them, which take minutes.
#include "fdk_study.h"
#include "radiosity_study.h"
#include "test.h"

namespace gicube::plan_study {
namespace {

constexpr const char* kBoard = "emu:?fidelity=functional";

template <typename Cases>
auto named(const Cases& cases, const std::string& name) {
  const auto found = std::find_if(cases.begin(), cases.end(), [&](const auto& one) { return one.name == name; });
  if (found == cases.end()) throw std::runtime_error("none of that name: " + name);
  return *found;
}

class HeldOutWork : public testing::TestWithParam<const char*> {
 protected:
};
using HeldOutRadiosity = HeldOutWork;
using HeldOutScan = HeldOutWork;

TEST_P(HeldOutRadiosity, TheMeasuredErrorStaysUnderTheBoundAndRaysAreSaved) {
  const RadiosityScene scene = named(radiosity_scenes(GICUBE_SOURCE_DIR), GetParam());
  ASSERT_GT(scene.batch, 0);
  const RadiosityOutcome outcome = carry_out_radiosity(scene, kBoard);
  EXPECT_TRUE(outcome.plan.kept);
  EXPECT_LE(outcome.plan.chosen.error_bound, scene.max_error);
  EXPECT_LE(outcome.error, outcome.plan.chosen.error_bound);
  EXPECT_GT(outcome.error, 0);
  EXPECT_LT(3 * outcome.plan.chosen.all_rays, outcome.reference_rays);
}

TEST_P(HeldOutScan, TheMeasuredErrorStaysUnderTheBoundAndDepositsAreSaved) {
  const FdkScan scan = named(fdk_scans(), GetParam());
  ASSERT_GT(scan.batch, 0);
  const FdkOutcome outcome = carry_out_fdk(scan, kBoard);
  EXPECT_TRUE(outcome.plan.kept);
  EXPECT_LE(outcome.plan.chosen.error_bound, scan.max_error);
  EXPECT_LE(outcome.error, outcome.plan.chosen.error_bound);
  EXPECT_GT(outcome.error, 0);
  EXPECT_LT(1.9 * outcome.deposits, outcome.finest_deposits);  // as many rays at least, in half steps
  // Rays that carry nothing are not sent, and the few views that tell the cost have more of them (docs/guide/plan.md).
  EXPECT_NEAR(outcome.plan.chosen.deposits, outcome.deposits, 0.5 * outcome.deposits);
}

std::string letters(const testing::TestParamInfo<const char*>& name) {
  std::string text;
  for (const char* c = name.param; *c != 0; ++c) {
    if (std::isalnum(static_cast<unsigned char>(*c)) != 0) text += *c;
  }
  return text;
}

INSTANTIATE_TEST_SUITE_P(Scenes, HeldOutRadiosity, testing::Values("white room, 10"), letters);
INSTANTIATE_TEST_SUITE_P(Scans, HeldOutScan, testing::Values("discs", "head, short scan", "small head, at 20%"),
                         letters);

}  // namespace
}  // namespace gicube::plan_study
