#include "cone_beam/scan/scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

using testing::HasSubstr;

std::string error_of(Stack views, const Stack& flats, const Stack& darks, double full) {
  try {
    correct_flat_field(views, flats, darks, full);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(FlatField, TakesTheLogarithmOfWhatIsLeftOfTheMeanFlat) {
  Stack views{2, 1, {110, 60, 35, 20}, true};
  const FlatFieldReport report = correct_flat_field(views, {2, 1, {100, 50, 120, 70}, true}, {2, 1, {10, 20}, true}, 0);
  EXPECT_EQ(report.absorbed, 1u);
  EXPECT_EQ(report.dead, 0u);
  EXPECT_NEAR(views.values[0], 0, 1e-6);
  EXPECT_NEAR(views.values[1], 0, 1e-6);
  EXPECT_NEAR(views.values[2], std::log(100 / 25.0), 1e-6);
  EXPECT_NEAR(views.values[3], std::log(40 / 0.5), 1e-6);  // nothing left: half a count
}

TEST(FlatField, KeepsWhatIsLighterThanTheFlat) {
  Stack views{2, 1, {200, 50}, true};
  correct_flat_field(views, {}, {}, 100);
  EXPECT_NEAR(views.values[0], -std::log(2), 1e-6);
  EXPECT_NEAR(views.values[1], std::log(2), 1e-6);
}

TEST(FlatField, TakesAMillionthForTheLeastOfFloats) {
  Stack views{2, 1, {-1, 0.25}, false};
  EXPECT_EQ(correct_flat_field(views, {}, {}, 1).absorbed, 1u);
  EXPECT_NEAR(views.values[0], std::log(1e6), 1e-4);
  EXPECT_NEAR(views.values[1], std::log(4), 1e-6);
}

TEST(FlatField, FillsDeadPixelsFromTheirRow) {
  Stack views{4, 2, {100, 7, 25, 50, 7, 7, 7, 7}, true};
  const Stack flats{4, 2, {100, 0, 100, 100, 0, 0, 0, 0}, true};
  EXPECT_EQ(correct_flat_field(views, flats, {}, 0).dead, 5u);
  EXPECT_NEAR(views.values[1], std::log(4) / 2, 1e-6);
  EXPECT_EQ(views.values[4], 0);  // a row without any
}

TEST(FlatField, RefusesWhatCannotBeOne) {
  const Stack views{2, 1, {1, 2}, true};
  EXPECT_THAT(error_of(views, {3, 1, {1, 2, 3}, true}, {}, 0), HasSubstr("flats: expected 2 x 1 pixels"));
  EXPECT_THAT(error_of(views, {}, {1, 2, {1, 2}, true}, 9), HasSubstr("darks: expected 2 x 1 pixels"));
  EXPECT_THAT(error_of(views, {}, {}, 0), HasSubstr("full: expected"));
  EXPECT_THAT(error_of(views, {2, 1, {1, 1}, true}, {2, 1, {1, 1}, true}, 0), HasSubstr("flats: expected some pixel"));
}

}  // namespace
}  // namespace gicube::samples
