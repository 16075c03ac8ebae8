// Ray making, clipping and the framebuffer.
#include "firmware/framebuffer.h"
#include "firmware/viewing_rays.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr Point kExtent{99 * wire::kVoxel, 49 * wire::kVoxel, 199 * wire::kVoxel};

TEST(Clip, FindsWhereALineEntersAndLeavesTheBox) {
  const auto interval = clip({{-10, 20, 50}, {2, 0, 0}}, kExtent, {});
  ASSERT_TRUE(interval);
  EXPECT_DOUBLE_EQ(interval->begin, 5);
  EXPECT_DOUBLE_EQ(interval->end, 54.5);
}

TEST(Clip, StartsAtAnOriginInside) { EXPECT_DOUBLE_EQ(clip({{10, 20, 50}, {1, 0, 0}}, kExtent, {})->begin, 0); }

TEST(Clip, MissesBesideAndBehind) {
  EXPECT_FALSE(clip({{-10, 60, 50}, {1, 0, 0}}, kExtent, {}));
  EXPECT_FALSE(clip({{-10, 20, 50}, {-1, 0, 0}}, kExtent, {}));
}

TEST(Clip, RunsInAFaceEdgeAndCorner) {
  EXPECT_TRUE(clip({{-10, 0, 0}, {1, 0, 0}}, kExtent, {}));    // along an edge
  EXPECT_TRUE(clip({{-10, 49, 50}, {1, 0, 0}}, kExtent, {}));  // in the far face
  EXPECT_TRUE(clip({{-1, -1, -1}, {1, 1, 1}}, kExtent, {}));   // through a corner
}

TEST(Clip, CutsWithAPlane) {
  const Plane keep_right{{16384, 0, 0}, std::int64_t{30} << kPlaneFractionBits};
  const auto interval = clip({{-10, 20, 50}, {1, 0, 0}}, kExtent, std::span(&keep_right, 1));
  EXPECT_DOUBLE_EQ(interval->begin, 40);
  EXPECT_FALSE(clip({{29, 20, 50}, {-1, 0, 0}}, kExtent, std::span(&keep_right, 1)));
}

TEST(ViewingRay, StartsOnTheBoxAndNeverOutsideForRandomLines) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-300, 300);
  int hits = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const Line line{{anywhere(random), anywhere(random), anywhere(random)},
                    {anywhere(random), anywhere(random), anywhere(random)}};
    const auto ray = viewing_ray(line, 0, 0, kExtent, {});
    if (!ray) continue;
    ++hits;
    double norm = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_LE(ray->position[axis], static_cast<std::uint32_t>(kExtent[axis]));
      norm += std::pow(ray->direction[axis] / 16384.0, 2);
    }
    ASSERT_NEAR(norm, 1, 2e-4);
  }
  EXPECT_GT(hits, 100);
}

TEST(ViewingRay, GoesThroughItsImagePoint) {
  wire::RenderCommand command;
  command.origin = {50, 25, -100};
  command.forward = {-0.5, -0.5, 1};
  command.du = {0.01, 0, 0};
  command.dv = {0, 0.01, 0};
  const Line line = viewing_line(command, 50, 50);
  EXPECT_NEAR(line.direction[0], 0, 1e-12);
  command.projection = wire::Projection::kOrthographic;
  command.du = {1, 0, 0};
  EXPECT_DOUBLE_EQ(viewing_line(command, 3.5, 0).origin[0], 53.5);
}

wire::Ray returned(int u, int v, std::uint16_t red, std::uint32_t opacity) {
  wire::Ray ray;
  ray.u = static_cast<std::uint16_t>(u);
  ray.v = static_cast<std::uint16_t>(v);
  ray.colour = {red, 0, 0};
  ray.opacity = opacity;
  return ray;
}

TEST(Framebuffer, TurnsFullWordsIntoFullPixels) {
  Framebuffer framebuffer;
  framebuffer.clear(2, 1, wire::Filter::kBox);
  framebuffer.add(returned(8, 8, 4095, wire::kOpacityOne));
  EXPECT_EQ(framebuffer.pixel(0, 0), (wire::Pixel{255, 0, 0, 4095}));
  EXPECT_EQ(framebuffer.pixel(1, 0), wire::Pixel{});
}

// Half a unit goes up, as std::round() does: the lowest place of which that is true, and the next ones below and above.
TEST(ViewingRay, APlaceHalfWayBetweenTwoWordsGoesUp) {
  constexpr double kUnit = 1.0 / wire::kVoxel;
  for (const std::uint32_t k : {0u, 1u, 12'345u, 800'000u}) {
    const auto at = [k](double rest) {
      const double x = (k + rest) * kUnit;
      return viewing_ray({{x, x, x}, {1, -1, 0.5}}, 0, 0, kExtent, {})->position;
    };
    EXPECT_EQ(at(0.25), (std::array{k, k, k}));
    EXPECT_EQ(at(0.5), (std::array{k + 1, k + 1, k + 1}));
    EXPECT_EQ(at(0.75), (std::array{k + 1, k + 1, k + 1}));
  }
  EXPECT_EQ(viewing_ray({{98.99999999, 49, 3}, {0, 0, 1}}, 0, 0, kExtent, {})->position[0], 99u << 14);
}

TEST(ViewingRay, HasTheNearestDirectionWordsOfEitherSign) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 20'000; ++i) {
    const std::array<double, 3> d{any(random), any(random), any(random)};
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const auto ray = viewing_ray({{50, 25, 100}, d}, 17, 33, kExtent, {});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(ray->direction[axis], std::lround(d[axis] / length * 16384));
    }
    ASSERT_EQ(ray->u, 17);
    ASSERT_EQ(ray->v, 33);
  }
}

TEST(ViewingRay, IsNoneWithoutADirection) {
  const std::array<double, 3> inside{1, 1, 1};
  EXPECT_TRUE(viewing_ray({inside, {0, 0, 1}}, 0, 0, kExtent, {}));
  EXPECT_FALSE(viewing_ray({inside, {0, 0, 0}}, 0, 0, kExtent, {}));
  EXPECT_FALSE(viewing_ray({inside, {0, 0, 1e-300}}, 0, 0, kExtent, {})) << "its square is 0";
  EXPECT_FALSE(viewing_ray({inside, {0, 0, 1e300}}, 0, 0, kExtent, {})) << "its square is infinite";
}

TEST(Framebuffer, AveragesTheRaysOfAPixelByTheBoxFilter) {
  Framebuffer framebuffer;
  framebuffer.clear(1, 1, wire::Filter::kBox);
  framebuffer.add(returned(4, 4, 4095, wire::kOpacityOne));
  for (const auto& [u, v] : {std::pair(12, 4), std::pair(4, 12), std::pair(12, 12)})
    framebuffer.add(returned(u, v, 0, 0));
  EXPECT_EQ(framebuffer.pixel(0, 0), (wire::Pixel{64, 0, 0, 1024}));
}

TEST(Framebuffer, KeepsAConstantImageConstantUnderTheTentFilter) {
  Framebuffer framebuffer;
  framebuffer.clear(5, 4, wire::Filter::kTent);
  for (int v = 2; v < 4 * 16; v += 4) {
    for (int u = 2; u < 5 * 16; u += 4) framebuffer.add(returned(u, v, 1000, 1u << 22));
  }
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) EXPECT_EQ(framebuffer.pixel(x, y), framebuffer.pixel(0, 0));
  }
  EXPECT_EQ(framebuffer.pixel(0, 0).red, 62);  // 1000 / 4095 * 255
}

TEST(Framebuffer, SpreadsARayOverThePixelsLessThanAPixelAwayByTheTentFilter) {
  Framebuffer framebuffer;
  framebuffer.clear(3, 3, wire::Filter::kTent);
  framebuffer.add(returned(16 + 8, 16 + 8, 4095, wire::kOpacityOne));  // pixel (1, 1)'s centre
  framebuffer.add(returned(16 + 8, 8, 0, 0));                          // pixel (1, 0)'s centre
  EXPECT_EQ(framebuffer.pixel(1, 1).red, 255);
  EXPECT_EQ(framebuffer.pixel(1, 0).red, 0);
  framebuffer.add(returned(16 + 8, 16, 4095, wire::kOpacityOne));  // half way between the two
  EXPECT_EQ(framebuffer.pixel(1, 0).red, 85);                      // weights 256 and 128
}

TEST(Framebuffer, ARayBetweenFourCentresCountsForAllFourPixelsByTheTentFilter) {
  Framebuffer framebuffer;
  framebuffer.clear(2, 2, wire::Filter::kTent);
  framebuffer.add(returned(16, 16, 4095, wire::kOpacityOne));
  for (const int y : {0, 1}) {
    for (const int x : {0, 1}) EXPECT_EQ(framebuffer.pixel(x, y), (wire::Pixel{255, 0, 0, 4095})) << x << ' ' << y;
  }
}

TEST(Framebuffer, PacksTwoPixelsInNineBytes) {
  Framebuffer framebuffer;
  framebuffer.clear(3, 1, wire::Filter::kBox);
  framebuffer.add(returned(2 * 16, 0, 4095, wire::kOpacityOne));
  const auto bytes = framebuffer.packed();
  EXPECT_EQ(bytes.size(), 14u);
  EXPECT_EQ(wire::to_pixel(wire::load36(bytes, 2)), framebuffer.pixel(2, 0));
}

TEST(Framebuffer, PacksTheSameBytesOnAnyNumberOfThreads) {
  Framebuffer framebuffer;
  framebuffer.clear(7, 5, wire::Filter::kBox);
  for (std::uint16_t i = 0; i < 35; ++i) {
    framebuffer.add(returned(i % 7 * 16, i / 7 * 16, static_cast<std::uint16_t>(100 * i), 400'000u * i));
  }
  const auto bytes = framebuffer.packed();
  for (const unsigned threads : {2u, 3u, 16u, 40u}) EXPECT_EQ(framebuffer.packed(threads), bytes) << threads;
}

// A byte of two threads would lose what one of them writes, too rarely for a test to meet it.
TEST(Framebuffer, PacksNoByteOnTwoThreads) {
  for (unsigned threads = 1; threads <= 8; ++threads) {
    for (std::size_t pixels = 1; pixels <= 100; ++pixels) {
      const std::size_t run = Framebuffer::pixels_at_once(pixels, threads);
      EXPECT_EQ(run % 2, 0u) << pixels << ' ' << threads;
      EXPECT_GE(run * threads, pixels);
    }
  }
}

TEST(Framebuffer, SumsTheSameForAThreadThatIsAlone) {
  for (const wire::Filter filter : {wire::Filter::kBox, wire::Filter::kTent}) {
    Framebuffer shared, alone;
    for (Framebuffer* framebuffer : {&shared, &alone}) framebuffer->clear(4, 3, filter);
    for (unsigned i = 0; i < 60; ++i) {  // some beside the image
      const wire::Ray ray = returned(static_cast<int>(i * 7 % 80), static_cast<int>(i * 11 % 64),
                                     static_cast<std::uint16_t>(60 * i), 250'000 * i);
      shared.add(ray);
      alone.add_alone(ray);
    }
    EXPECT_EQ(alone.packed(), shared.packed());
  }
}

// The first 16 places of a row are its first pixel.
TEST(Framebuffer, PutsWhatAThreadAddsAloneIntoItsOwnPixel) {
  Framebuffer framebuffer;
  framebuffer.clear(300, 1, wire::Filter::kBox);
  for (const int u : {1, 15, 16}) framebuffer.add_alone(returned(u, 3, 4095, wire::kOpacityOne));
  for (int x = 0; x < 300; ++x) EXPECT_EQ(framebuffer.pixel(x, 0).red, x < 2 ? 255 : 0) << x;
}

}  // namespace
}  // namespace gicube::emu
