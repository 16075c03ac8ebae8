#include "filter.h"

#include <gtest/gtest.h>

namespace gicube::reference {
namespace {

constexpr double kExact = 1e-12;

// `size` x `size` rays; ray (x, y) has opacity f(x, y) and that as its colour.
template <typename F>
Picture make_rays(int size, const F& f) {
  Picture rays{size, size, {}};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double level = f(x, y);
      rays.pixels.push_back({{level, level, level}, level});
    }
  }
  return rays;
}

TEST(Filter, KeepsAConstantPictureConstantToItsEdges) {
  for (const int per_axis : {1, 2, 4}) {
    for (const PixelFilter kind : {PixelFilter::kBox, PixelFilter::kTent}) {
      const Picture picture = filter(make_rays(8, [](int, int) { return 0.3; }), per_axis, kind);
      ASSERT_EQ(picture.width, 8 / per_axis);
      for (const Rgba& pixel : picture.pixels) {
        EXPECT_NEAR(pixel.opacity, 0.3, kExact);
        EXPECT_NEAR(pixel.colour[2], 0.3, kExact);
      }
    }
  }
}

TEST(BoxFilter, IsTheMeanOfAPixelsOwnRays) {
  const Picture picture = filter(make_rays(4, [](int x, int y) { return x + 10 * y; }), 2, PixelFilter::kBox);
  EXPECT_NEAR(picture.at(0, 0).opacity, 5.5, kExact);
  EXPECT_NEAR(picture.at(1, 1).opacity, 27.5, kExact);
}

TEST(TentFilter, KeepsALinearPictureLinearInside) {
  const Picture picture = filter(make_rays(16, [](int x, int y) { return x - 2 * y; }), 4, PixelFilter::kTent);
  // The middle of pixel 1 is at ray coordinate 5.5.
  EXPECT_NEAR(picture.at(1, 1).opacity, 5.5 - 2 * 5.5, kExact);
  EXPECT_NEAR(picture.at(2, 1).opacity, 9.5 - 2 * 5.5, kExact);
}

TEST(TentFilter, WeighsByDistanceAndOverTheRaysInTheImage) {
  // Two rays a pixel and axis, 1/4 and 3/4 of a pixel away: weights 3/4 and 1/4; a corner pixel lacks its outer 1/4s.
  const Picture picture = filter(make_rays(8, [](int x, int y) { return x == 2 && y == 2; }), 2, PixelFilter::kTent);
  EXPECT_NEAR(picture.at(1, 1).opacity, 0.75 * 0.75 / (2 * 2), kExact);
  EXPECT_NEAR(picture.at(0, 1).opacity, 0.25 * 0.75 / (1.75 * 2), kExact);
  EXPECT_NEAR(picture.at(2, 1).opacity, 0, kExact);  // 1.25 pixels away
}

TEST(TentFilter, WithOneRayAPixelIsThatRay) {
  const Picture rays = make_rays(4, [](int x, int y) { return x * y; });
  EXPECT_EQ(filter(rays, 1, PixelFilter::kTent).pixels, rays.pixels);
}

}  // namespace
}  // namespace gicube::reference
