#include "encode/argument.h"

#include "refusal.h"
#include "test.h"

namespace gicube {
namespace {

TEST(Argument, ARefusalNamesFieldExpectationAndValue) {
  EXPECT_EQ(refusal([] { expect_within("step", 17, 0.015625, 16); }), "step: expected 0.015625..16, got 17");
  EXPECT_EQ(refusal([] { expect_within("step", 16, 0.015625, 16); }), "accepted");
}

TEST(Argument, NanAndInfinityArePassedByNoCheck) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal([&] { expect_within("a", nan, 0, 1); }), "a: expected 0..1, got nan");
  EXPECT_EQ(refusal([&] { expect_finite("eye", Vec3{0, inf, 0}); }), "eye.y: expected a finite number, got inf");
}

TEST(Argument, UnitHoldsWhereSquaresWouldOverflowOrVanish) {
  for (const double size : {1e300, 1.0, 1e-300}) {
    const Vec3 v = unit({3 * size, 0, -4 * size});
    EXPECT_NEAR(v.x, 0.6, 1e-15);
    EXPECT_NEAR(v.z, -0.8, 1e-15);
  }
  EXPECT_EQ(unit(Vec3{}), Vec3{});
}

}  // namespace
}  // namespace gicube
