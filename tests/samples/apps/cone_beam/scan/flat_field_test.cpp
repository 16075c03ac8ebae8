#include "cone_beam/scan/scan.h"

#include "gicube/scene/error.h"
#include "test.h"

namespace gicube::samples {
namespace {

std::string error_of(Stack views, const Stack& flats, const Stack& darks, double full) {
  return message_of<InputError>([&] { correct_flat_field(views, flats, darks, full); });
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

// Eight views of 9 x 7 pixels of 100 counts, the logarithm of whose flat is p = 0.1 x + 0.2 y.
Stack sloped() {
  Stack views{9, 7, {}, true};
  for (int i = 0; i < 8 * 63; ++i) {
    views.values.push_back(static_cast<float>(std::round(1e6 * std::exp(-0.1 * (i % 9) - 0.2 * (i % 63 / 9)))));
  }
  return views;
}
double sloped_at(std::size_t i) { return 0.1 * static_cast<double>(i % 9) + 0.2 * static_cast<double>(i % 63 / 9); }

TEST(FlatField, FillsColumnsRowsAndPixelsThatGotNoLightInAnyView) {
  const auto column = [](std::size_t x, std::size_t) { return x == 4; };
  const auto columns = [](std::size_t x, std::size_t) { return x == 4 || x == 5; };
  const auto row = [](std::size_t, std::size_t y) { return y == 3; };
  const auto pixel = [](std::size_t x, std::size_t y) { return x == 2 && y == 5; };
  const auto expect_filled = [](const auto& dead, std::size_t many, double error) {
    Stack views = sloped();
    for (std::size_t i = 0; i < views.values.size(); ++i) {
      if (dead(i % 9, i % 63 / 9)) views.values[i] = i % 2 == 0 ? 10 : 9;  // the dark's own
    }
    const Stack darks{9, 7, std::vector<float>(63, 10), true}, flats{9, 7, std::vector<float>(63, 1e6F + 10), true};
    for (std::size_t i = 0; i < views.values.size(); ++i) {
      if (!dead(i % 9, i % 63 / 9)) views.values[i] += 10;
    }
    const FlatFieldReport report = correct_flat_field(views, flats, darks, 0);
    EXPECT_EQ(report.unlit, many);
    EXPECT_EQ(report.absorbed, 0u);
    EXPECT_EQ(report.dead, 0u);
    for (std::size_t i = 0; i < views.values.size(); ++i) ASSERT_NEAR(views.values[i], sloped_at(i), error) << i;
  };
  expect_filled(column, 7, 1e-5);
  expect_filled(columns, 14, 0.05 + 1e-5);
  expect_filled(row, 9, 1e-5);
  expect_filled(pixel, 1, 1e-5);
}

TEST(FlatField, KeepsWhatAnObjectTakesAllOf) {
  Stack views = sloped();
  for (std::size_t i = 0; i < views.values.size(); ++i) {
    if (i % 9 >= 2 && i % 9 <= 6 && i % 63 / 9 >= 1 && i % 63 / 9 <= 5)
      views.values[i] = 0;                               // a wide one, in each view
    if (i % 9 == 8 && i / 63 != 3) views.values[i] = 0;  // a narrow one, but in one
  }
  const FlatFieldReport report = correct_flat_field(views, {}, {}, 1e6);
  EXPECT_EQ(report.unlit, 0u);
  EXPECT_EQ(report.absorbed, 8u * 25 + 7 * 7);
}

TEST(FlatField, RefusesWhatCannotBeOne) {
  const Stack views{2, 1, {1, 2}, true};
  EXPECT_THAT(error_of(views, {3, 1, {1, 2, 3}, true}, {}, 0), HasSubstr("flats: expected 2 x 1 pixels"));
  EXPECT_THAT(error_of(views, {}, {1, 2, {1, 2}, true}, 9), HasSubstr("darks: expected 2 x 1 pixels"));
  EXPECT_THAT(error_of(views, {}, {}, 0), HasSubstr("full: expected"));
  EXPECT_THAT(error_of(views, {2, 1, {1, 1}, true}, {2, 1, {1, 1}, true}, 0), HasSubstr("flats: expected some pixel"));
}

// Twelve views of 9 x 7 pixels whose values change smoothly, and linearly from pixel to pixel.
Stack changing() {
  Stack stack{9, 7, {}, false};
  for (int view = 0; view < 12; ++view) {
    for (int i = 0; i < 63; ++i) stack.values.push_back(static_cast<float>(i % 9 + (i / 9) * 2 + 3 * std::sin(view)));
  }
  return stack;
}

TEST(DeadPixels, ThatAreStuckAreFoundAndInterpolated) {
  const Stack whole = changing();
  for (const float stuck : {0.0F, 65535.0F, 7.5F}) {  // a dead, a hot and a stuck column, and one pixel
    Stack stack = whole;
    for (std::size_t i = 0; i < stack.values.size(); ++i) {
      if (i % 9 == 4 || i % 63 == 20) stack.values[i] = stuck;
    }
    const DeadPixels found = repair_pixels(stack, {});
    EXPECT_EQ(found.stuck, 8u);
    EXPECT_EQ(found.named, 0u);
    for (std::size_t i = 0; i < stack.values.size(); ++i) EXPECT_NEAR(stack.values[i], whole.values[i], 1e-4) << i;
  }
}

TEST(DeadPixels, ThatAMapNamesAreInterpolatedByTheirDistance) {
  const Stack whole = changing();
  Stack stack = whole, map{9, 7, std::vector<float>(63), true};
  for (std::size_t row = 0; row < 7; ++row) map.values[row * 9 + 4] = map.values[row * 9 + 5] = 1;  // two columns
  for (std::size_t i = 0; i < stack.values.size(); ++i)
    stack.values[i] += map.values[i % 63] * static_cast<float>(i % 5);
  EXPECT_EQ(repair_pixels(stack, map).named, 14u);
  for (std::size_t i = 0; i < stack.values.size(); ++i) EXPECT_NEAR(stack.values[i], whole.values[i], 1e-4) << i;
  Stack again = whole;
  EXPECT_EQ(repair_pixels(again, {}).stuck, 0u);
  EXPECT_EQ(again.values, whole.values);
  map.columns = 7, map.rows = 9;
  EXPECT_THROWS(InputError, "dead: expected 9 x 7 pixels", repair_pixels(stack, map));
}

// A pixel that no view changes, as the air beside an object, is no fault.
TEST(DeadPixels, OfAirAreNone) {
  Stack stack = changing();
  for (std::size_t i = 0; i < stack.values.size(); ++i) {
    if (i % 9 < 3) stack.values[i] = 0;
  }
  EXPECT_EQ(repair_pixels(stack, {}).stuck, 0u);
}

}  // namespace
}  // namespace gicube::samples
