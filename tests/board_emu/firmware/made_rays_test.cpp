// The rays that the DSP makes of a picture and of a light, and the vectors for them.
#include "commands_rig.h"
#include "firmware/framebuffer.h"
#include "firmware/lighting_rays.h"
#include "firmware/ray_sources/image_rays.h"
#include "test.h"
#include "words/vectors.h"

namespace gicube::emu {
namespace {

// Centres of pixels, or of their quarters, in an image of one tile of 16 pixels and in one of four.
void expect_rays_in_the_middle(int pixels) {
  wire::RenderCommand view = corner_view({17, 17, 17}, pixels);
  Frame frame;
  frame.extent = {16 << 14, 16 << 14, 16 << 14};
  for (const auto& [samples, first, step] : {std::array{1, 8, 16}, {2, 4, 8}, {4, 2, 4}}) {
    view.samples_per_axis = static_cast<std::uint8_t>(samples);
    Framebuffer framebuffer;
    framebuffer.clear(pixels, pixels, wire::Filter::kBox);
    ImageRays rays(view, frame, framebuffer);
    ASSERT_EQ(rays.count(), static_cast<std::uint64_t>(pixels * pixels * samples * samples));
    RayCounters counters;
    const int across = pixels * samples;
    int seen = 0;
    for (int i = 0; i < across * across; ++i) {
      const auto ray = rays.make(static_cast<std::uint64_t>(i), counters);
      if (!ray) continue;
      ++seen;
      EXPECT_EQ(ray->u, first + i % across * step);
      EXPECT_EQ(ray->v, first + i / across * step);
    }
    EXPECT_GT(seen, 0);
    std::size_t in_batches = 0;
    for (std::size_t b = 0; b < rays.divide(1000); ++b) {
      const auto batch = rays.make_batch(b);
      for (const wire::Ray& ray : batch->rays) {
        EXPECT_EQ((ray.u - first) % step, 0);
        EXPECT_EQ((ray.v - first) % step, 0);
        ++in_batches;
      }
    }
    EXPECT_EQ(in_batches, static_cast<std::size_t>(seen));
  }
}

TEST(ImageRays, LieInTheMiddleOfTheirPlaceInThePixel) {
  expect_rays_in_the_middle(4);
  expect_rays_in_the_middle(20);
}

// Tiles of 16 x 16 pixels, the last of a row or column with what is left.
TEST(ImageRays, AreMadeInTilesThatCoverTheImage) {
  Frame frame;
  frame.extent = {16 << 14, 16 << 14, 16 << 14};
  for (const auto& [width, height, tiles] :
       {std::array{1, 1, 1}, {16, 16, 1}, {17, 16, 2}, {16, 17, 2}, {18, 33, 6}, {33, 18, 6}, {100, 1, 7}}) {
    wire::RenderCommand view = corner_view({17, 17, 17}, 16);
    view.width = static_cast<std::uint16_t>(width);
    view.height = static_cast<std::uint16_t>(height);
    Framebuffer framebuffer;
    ImageRays rays(view, frame, framebuffer);
    EXPECT_EQ(rays.divide(1000), static_cast<std::size_t>(tiles)) << width << " x " << height;
  }
}

TEST(LightingRays, StartAtTheNearestWordsAndRunAlongTheNearestDirection) {
  const Point extent{16 << 14, 16 << 14, 16 << 14};
  wire::IlluminateCommand command;
  command.kind = wire::LightKind::kDirectional;
  command.energy = 200;
  command.u = {1, 2, 3};
  command.rays_per_voxel = command.count = 1;
  const LightingRays sun(command, extent, {65536, 65536, 65536}, 8, 1);
  int rays = 0;
  for (std::uint64_t i = 0; i < sun.count(); ++i) {
    const auto ray = sun.make(i);
    if (!ray) continue;
    ++rays;
    EXPECT_EQ(ray->direction, (std::array<std::int16_t, 3>{-4379, -8758, -13136}));
  }
  EXPECT_GT(rays, 500);
  command.kind = wire::LightKind::kPoint;
  command.position = {3 + 0.7 / 16384, 4 + 0.2 / 16384, 5 + 0.5 / 16384};
  command.energy = 40'000;
  const LightingRays lamp(command, extent, {65536, 65536, 65536}, 8, 1);
  for (std::uint64_t i = 0; i < lamp.count(); ++i) {
    const auto ray = lamp.make(i);
    if (ray) {
      ASSERT_EQ(ray->position, (std::array<std::uint32_t, 3>{(3u << 14) + 1, 4u << 14, (5u << 14) + 1}));
    }
  }
}

TEST(Vectors, TurnAboutTheAxisFromXToY) {
  const auto near = [](const Vector& got, const Vector& expected) {
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(got[axis], expected[axis], 1e-12);
  };
  near(around({0, 0, 1}, 1, 0.3), {0, 0, 1});
  near(around({0, 0, 1}, 0, 0), {1, 0, 0});
  near(around({0, 0, 1}, 0, 0.25), {0, 1, 0});
  near(around({0, 0, 1}, -0.6, 0.5), {-0.8, 0, -0.6});
}

}  // namespace
}  // namespace gicube::emu
