// Viewing rays in segments between slabs.
#include "firmware/ray_sources/segment_rays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "asic/partition.h"
#include "firmware/ray_sources/image_rays.h"
#include "machine_rig.h"
#include "random_machine.h"

namespace gicube::emu {
namespace {

constexpr int kBlock = 16;

struct Cloud : Scene {
  explicit Cloud(std::uint16_t opacity) : Scene({64, 48, 40}, kBlock) {
    fill([](int x, int y, int z) {
      return wire::Voxel{static_cast<std::uint16_t>((x * 37 + y * 91 + z * 53) % 4096), 0, 0, 0};
    });
    for (std::size_t i = 0; i < segmentation.size(); ++i) {
      segmentation[i].opacity = static_cast<std::uint16_t>(i % 3 == 0 ? 0 : opacity);
      segmentation[i].colour = {static_cast<std::uint16_t>(i % 4096), 2000, 900};
    }
  }
};

std::vector<std::int32_t> borders_of(const v1::BoardConfig& config, const Scene& scene) {
  std::vector<int> borders = Partition(config.asic(), scene.volume.blocks()).borders(scene.volume.blocks()[0]);
  for (int& border : borders) border *= kBlock * wire::kVoxel;
  return borders;
}

v1::BoardConfig slabs(unsigned processors, const char* partition = "asic.partition=simple_slab") {
  return config_with({"asic.block_voxels=16", "asic.processors=" + std::to_string(processors), partition});
}

Picture functional_parts(Scene& scene, const wire::RenderCommand& view, const v1::BoardConfig& config,
                         unsigned threads = 1) {
  Picture picture;
  Framebuffer framebuffer;
  scene.frame.ends_at_borders = true;
  SegmentRays rays(view, scene.frame, framebuffer, borders_of(config, scene));
  picture.rays = run_functional(rays, scene.frame, threads).rays;
  picture.pixels = framebuffer.packed();
  scene.frame.ends_at_borders = false;
  return picture;
}

Picture cycle_parts(Scene& scene, const wire::RenderCommand& view, const v1::BoardConfig& config) {
  Picture picture;
  Framebuffer framebuffer;
  scene.frame.ends_at_borders = true;
  SegmentRays rays(view, scene.frame, framebuffer, borders_of(config, scene));
  Machine machine(config, scene.volume.blocks());
  Progress progress;
  picture.ran = machine.run(rays, scene.frame, progress);
  picture.rays = ray_counters(machine);
  picture.pixels = framebuffer.packed();
  for (std::uint32_t p = 0; p < config.asic().processors(); ++p) EXPECT_EQ(machine.links().counters(p).sent, 0u);
  scene.frame.ends_at_borders = false;
  return picture;
}

TEST(SegmentRays, HaveTheSameBitsAtBothLevelsAndNoneGoesOverALink) {
  Cloud scene(300);
  Dice dice(5);
  for (int i = 0; i < 24; ++i) {
    scene.frame.jitter = i % 3 == 1;
    scene.frame.leap = i % 2 == 1;
    for (auto& empty : scene.frame.empty) empty = dice.chance(30) ? 1 : 0;
    scene.frame.cut_planes.clear();
    if (i % 4 == 3) scene.frame.cut_planes.push_back({{8000, 9000, -4000}, std::int64_t{20} << 28});
    const wire::RenderCommand view = draw_view(scene, dice);
    const v1::BoardConfig config =
        slabs(static_cast<unsigned>(dice.number(1, 4)),
              dice.chance(50) ? "asic.partition=simple_slab" : "asic.partition=repeated_slab");
    const Picture values = functional_parts(scene, view, config, 2), timed = cycle_parts(scene, view, config);
    EXPECT_EQ(values.pixels, timed.pixels) << i;
    EXPECT_EQ(values.rays.samples, timed.rays.samples) << i;
    EXPECT_EQ(values.rays.rays, timed.rays.rays) << i;
  }
}

// A part adds a rounding to each of the pixel's four words, of 8 and 12 bits.
TEST(SegmentRays, WithoutJitterTakeTheSamplesOfWholeRaysAndDifferByRoundings) {
  Cloud scene(1200);
  scene.frame.opacity_threshold = wire::kOpacityOne;
  for (const int image : {40, 61}) {
    const wire::RenderCommand view = corner_view(scene.volume.size(), image);
    const Picture whole = functional_picture(scene, view), parts = functional_parts(scene, view, slabs(4));
    EXPECT_EQ(parts.rays.samples, whole.rays.samples);
    EXPECT_NE(parts.pixels, whole.pixels);
    for (std::size_t i = 0; i < static_cast<std::size_t>(image * image); ++i) {
      const wire::Pixel a = wire::to_pixel(wire::load36(whole.pixels, i)),
                        b = wire::to_pixel(wire::load36(parts.pixels, i));
      EXPECT_LE(std::abs(a.red - b.red), 1) << i;
      EXPECT_LE(std::abs(a.green - b.green), 1) << i;
      EXPECT_LE(std::abs(a.blue - b.blue), 1) << i;
      EXPECT_LE(std::abs(a.alpha - b.alpha), 4) << i;
    }
  }
}

TEST(SegmentRays, OfOneProcessorAreWholeRays) {
  Cloud scene(300);
  const wire::RenderCommand view = corner_view(scene.volume.size(), 33);
  EXPECT_EQ(functional_parts(scene, view, slabs(1)).pixels, functional_picture(scene, view).pixels);
}

TEST(SegmentRays, OpaquePartsEndNoOthers) {
  Cloud scene(4000);
  scene.frame.opacity_threshold = wire::kOpacityOne / 2;
  wire::RenderCommand view = corner_view(scene.volume.size(), 24);
  view.projection = wire::Projection::kOrthographic;
  view.origin = {-5, -1, -1};
  view.forward = {1, 0, 0};
  view.du = {0, 2, 0};
  view.dv = {0, 0, 2};
  const std::uint64_t whole = functional_picture(scene, view).rays.samples;
  const std::uint64_t parts = functional_parts(scene, view, slabs(4)).rays.samples;
  EXPECT_GT(parts, 3 * whole);
}

// Along x, four slabs of 16 voxels each: all four parts of a ray fly at once, so it takes little more than a quarter of the time.
TEST(SegmentRays, AreCastAtTheSameTime) {
  Cloud scene(1);
  wire::RenderCommand view = corner_view(scene.volume.size(), 8);
  view.projection = wire::Projection::kOrthographic;
  view.origin = {-5, 10, 10};
  view.forward = {1, 0, 0};
  view.du = {0, 1, 0};
  view.dv = {0, 0, 1};
  v1::BoardConfig config = slabs(4);
  config.mutable_ideal()->set_dsp(1);
  Machine machine(config, scene.volume.blocks());
  const std::uint64_t whole = cycle_picture(scene, view, machine).ran.cycles;
  const std::uint64_t parts = cycle_parts(scene, view, config).ran.cycles;
  EXPECT_LT(parts, whole / 2);
}

}  // namespace
}  // namespace gicube::emu
