#include "compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace gicube::reference {
namespace {

constexpr double kExact = 1e-9;

Picture uniform(int width, int height, double level) {
  return {width, height,
          std::vector<Rgba>(static_cast<std::size_t>(width * height), Rgba{{level, level, level}, level})};
}

TEST(Comparison, OfAnErrorOfATenthEverywhereIsTwentyDecibel) {
  const Difference difference = compare(uniform(4, 3, 0.6), uniform(4, 3, 0.5));
  EXPECT_NEAR(difference.psnr_db, 20, kExact);
  EXPECT_NEAR(difference.rmse, 0.1, kExact);
  EXPECT_NEAR(difference.max_error, 0.1, kExact);
  EXPECT_EQ(difference.covered, 1);
}

TEST(Comparison, OfEqualPicturesIsInfinite) {
  EXPECT_TRUE(std::isinf(compare(uniform(2, 2, 0.5), uniform(2, 2, 0.5)).psnr_db));
}

TEST(Comparison, CountsOneChannelOfOnePixelAsItsShareOfAll) {
  Picture picture = uniform(4, 4, 0);
  picture.pixels[5].opacity = 0.5;
  const Difference difference = compare(picture, uniform(4, 4, 0));
  EXPECT_NEAR(difference.rmse, 0.5 / 8, kExact);
  EXPECT_EQ(difference.max_error, 0.5);
  EXPECT_EQ(difference.covered, 1 / 16.0);
  EXPECT_NEAR(difference.covered_psnr_db, -20 * std::log10(0.25), kExact);
}

TEST(Comparison, TakesTheBoardsWordsOver255And4095) {
  const Image image{1, 1, {{255, 51, 0, 819}}};
  const Picture reference{1, 1, {Rgba{{1, 0.2, 0}, 0.2}}};
  EXPECT_NEAR(compare(image, reference).max_error, 0, kExact);
}

TEST(Comparison, RefusesPicturesOfDifferentSizes) {
  EXPECT_THROW(compare(uniform(2, 3, 0), uniform(3, 2, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace gicube::reference
