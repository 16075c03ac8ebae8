// Rays side by side in vectors give the bits of the plain way, ray by ray and count by count, on every instruction set
// that this host has.
#include "functional/simd/simd_tracer.h"

#include "functional/functional.h"
#include "instruction_sets.h"
#include "random_machine.h"
#include "seeds.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr std::array<int, 3> kSize{45, 21, 34};

struct LitScene : Scene {
  LitScene(const std::array<int, 3>& size, int block_voxels, wire::VoxelFormat format = wire::VoxelFormat::kDensity)
      : Scene(size, block_voxels, format), irradiance(block_voxels, IrradianceMemory::kWideMost) {
    irradiance.resize(size);
    frame.irradiance = &irradiance;
  }

  IrradianceMemory irradiance;
};

struct Rays {
  std::vector<wire::Ray> rays;
  RayCounters counters;
};

Rays plainly(std::vector<wire::Ray> rays, const Frame& frame) {
  Rays out{std::move(rays), {}};
  for (wire::Ray& ray : out.rays) integrate(ray, frame, out.counters);
  return out;
}

Rays by_vectors(std::vector<wire::Ray> rays, const Frame& frame, const SimdTracer& packets) {
  Rays out{std::move(rays), {}};
  packets.trace(out.rays, frame, out.counters);
  return out;
}

void expect_equal(const Rays& got, const Rays& expected) {
  ASSERT_EQ(got.rays.size(), expected.rays.size());
  for (std::size_t i = 0; i < got.rays.size(); ++i) ASSERT_EQ(got.rays[i], expected.rays[i]) << "ray " << i;
  EXPECT_EQ(got.counters.rays, expected.counters.rays);
  EXPECT_EQ(got.counters.samples, expected.counters.samples);
  EXPECT_EQ(got.counters.visible_samples, expected.counters.visible_samples);
  EXPECT_EQ(got.counters.leaps, expected.counters.leaps);
  EXPECT_EQ(got.counters.terminated, expected.counters.terminated);
}

// Half of the frames: irradiance in some blocks, more than a word of the interpolator has in some voxels.
void draw_light(LitScene& scene, Dice& dice) {
  Frame& frame = scene.frame;
  if (dice.chance(40)) scene.widen();
  frame.exposure = static_cast<std::uint32_t>(dice.one_of({4'000, 65'536, 900'000}));
  frame.lit_by_irradiance = dice.chance(50);
  if (!frame.lit_by_irradiance) return;
  for (int i = dice.number(0, 200); i > 0; --i) {
    Deposit deposit;
    for (std::size_t axis = 0; axis < 3; ++axis) deposit.voxel[axis] = dice.number(0, kSize[axis] - 2);
    for (std::uint32_t& share : deposit.shares) {
      share = static_cast<std::uint32_t>(dice.number(0, 500)) << (frame.wide ? dice.number(0, 22) : 0);
    }
    scene.irradiance.add(deposit);
  }
  scene.irradiance.expect_deposits();
}

void draw_cut_planes(Frame& frame, Dice& dice) {
  frame.cut_planes.clear();
  for (int i = frame.segments() ? 0 : dice.one_of({0, 0, 1, 3}); i > 0; --i) {
    Plane plane;
    for (std::size_t axis = 0; axis < 3; ++axis) plane.normal[axis] = dice.number(-16'384, 16'384);
    const Point middle{22 * wire::kVoxel, 10 * wire::kVoxel, 17 * wire::kVoxel};
    plane.offset = dot(plane.normal, middle) - std::int64_t{dice.number(0, 6)} * wire::kVoxel * wire::kVoxel;
    frame.cut_planes.push_back(plane);
  }
}

void draw_field(LitScene& scene, Dice& dice) {
  const bool tagged = dice.chance(50);
  const int air = dice.one_of({0, 0, 300}), radius = dice.number(4, 16);
  scene.fill([&](int x, int y, int z) {
    const int dx = x - 20, dy = y - 10, dz = z - 17, inside = radius * radius - dx * dx - dy * dy - dz * dz;
    wire::Voxel voxel;
    voxel.density = static_cast<std::uint16_t>(inside > 0 ? std::min(4095, 700 + inside * 40) : air);
    voxel.tag = static_cast<std::uint8_t>(tagged ? (x + y / 3) & 3 : 0);
    voxel.gradient = static_cast<std::uint16_t>((x * 7 + y * 131 + z * 31) % 2048);
    return voxel;
  });
  const bool glossy = dice.chance(50);
  const unsigned peak = static_cast<unsigned>(dice.one_of({3, 900, 20'000, 65'535}));
  for (std::size_t i = 0; i < scene.segmentation.size(); ++i) {
    const auto density = static_cast<unsigned>(i % 4096);
    const unsigned opacity = density < 250 ? 0 : std::min(65'535u, 1 + peak * density / 3000 + (i > 4095 ? 200 : 0));
    const auto byte = [&] { return static_cast<std::uint8_t>(dice.number(0, 255)); };
    const auto colour = [&] { return static_cast<std::uint16_t>(dice.number(0, 4095)); };
    scene.segmentation[i] = {
        {colour(), colour(), colour()}, static_cast<std::uint16_t>(opacity), byte(), byte(), byte()};
    if (glossy) scene.segmentation[i].specular = byte();
    scene.segmentation[i].opacity_fine = static_cast<std::int16_t>(opacity == 0 ? 0 : dice.number(-2048, 2047));
  }
  for (auto& gradient : scene.gradients) {  // of any length, also too short to be shaded
    for (auto& component : gradient)
      component = static_cast<std::int16_t>(dice.number(-511, 511) / dice.one_of({1, 1, 9}));
  }
  scene.gradients[5] = {511, -511, 511};
  scene.gradients[6] = {-511, -511, 0};
  scene.volume.decode(scene.gradients, true, 1);
  for (std::uint8_t& texel : scene.reflectance_map) texel = static_cast<std::uint8_t>(dice.number(0, 255));
  draw_light(scene, dice);
  Frame& frame = scene.frame;
  frame.jitter = dice.chance(30);
  using enum wire::RayType;
  if (!frame.jitter && dice.chance(50)) {
    frame.type = dice.one_of({kSegment, kSegment, kOpacity, kIntegral});
  } else {
    frame.type = dice.one_of({kIntegrate, kFirstHit});
  }
  if (frame.type != kSegment && frame.type != kIntegrate) frame.lit_by_irradiance = false;
  frame.shade = dice.chance(60);
  draw_cut_planes(frame, dice);
  frame.skip_empty = dice.chance(60);
  frame.step = static_cast<std::uint32_t>(dice.one_of({9'000, 32'768, 65'536, 150'000}));
  frame.opacity_threshold = dice.one_of<std::uint32_t>({1, wire::kOpacityOne / 3, wire::kOpacityOne});
  if (dice.chance(50)) frame.spacing = {65'536, 90'000, 131'072};
  for (std::uint8_t& flag : frame.empty) flag = dice.chance(40) ? 1 : 0;  // a wrong flag changes both ways alike
}

// Anywhere in the volume: also on its faces, along axes, of no length, and out of it.
std::vector<wire::Ray> draw_rays(Dice& dice, int count, const Frame& frame) {
  std::vector<wire::Ray> rays;
  for (int i = 0; i < count; ++i) {
    std::array<double, 3> position{}, direction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int last = kSize[axis] - 1;
      position[axis] = dice.chance(15) ? dice.one_of({0, 8, 16, last}) : dice.number(0, last * 100) / 100.0;
      direction[axis] = dice.chance(20) ? 0 : dice.number(-100, 100);
    }
    if (direction == std::array<double, 3>{}) direction[2] = 1;
    wire::Ray ray = host_ray(static_cast<std::uint32_t>(i + 1), position, direction);
    if (frame.segments()) {
      ray.set_colour_word(static_cast<std::uint64_t>(dice.one_of({0, 1, 700, dice.number(0, 60 << 16)})));
    } else if (dice.chance(20)) {  // carries what an earlier flight gathered
      ray.generation = static_cast<std::uint8_t>(dice.number(0, 1));
      ray.opacity = static_cast<std::uint32_t>(dice.number(0, wire::kOpacityOne));
      for (std::uint16_t& c : ray.colour) c = static_cast<std::uint16_t>(dice.number(0, 4095));
    }
    rays.push_back(ray);
  }
  return rays;
}

class RayPacketsOfRandomScenes : public testing::TestWithParam<unsigned> {};

TEST_P(RayPacketsOfRandomScenes, GivesTheBitsOfThePlainWay) {
  Dice dice(GetParam());
  const int n = dice.one_of({8, 16, 32});
  LitScene scene(kSize, n,
                 dice.one_of({wire::VoxelFormat::kDensity, wire::VoxelFormat::kRgb, wire::VoxelFormat::kRgba}));
  draw_field(scene, dice);
  SimdTracer packets(scene.opacity_correction);
  ASSERT_TRUE(packets.prepare(1 << 20, scene.frame, 0, 2));
  const auto rays = draw_rays(dice, dice.one_of({1, 15, 16, 17, 300}), scene.frame);
  const Rays expected = plainly(rays, scene.frame);
  on_every_target([&] { expect_equal(by_vectors(rays, scene.frame, packets), expected); });
}

INSTANTIATE_TEST_SUITE_P(Scenes, RayPacketsOfRandomScenes, seeds(400));

TEST(SimdTracer, FollowsTheVolumeAndTheLut) {
  Dice dice(7);
  LitScene scene(kSize, 16);
  draw_field(scene, dice);
  SimdTracer packets(scene.opacity_correction);
  ASSERT_TRUE(packets.prepare(1 << 20, scene.frame, 0, 1));
  const auto rays = draw_rays(dice, 200, scene.frame);
  const Rays before = by_vectors(rays, scene.frame, packets);

  scene.fill([](int x, int, int) { return wire::Voxel{.density = static_cast<std::uint16_t>(80 * x)}; });
  ASSERT_TRUE(packets.prepare(1 << 20, scene.frame, 0, 1));
  const Rays refilled = by_vectors(rays, scene.frame, packets);
  expect_equal(refilled, plainly(rays, scene.frame));
  EXPECT_NE(refilled.counters.visible_samples, before.counters.visible_samples);

  for (auto& entry : scene.segmentation) entry.opacity = 77;
  if (scene.frame.wide) scene.widen();
  ASSERT_TRUE(packets.prepare(1 << 20, scene.frame, 1, 1));
  expect_equal(by_vectors(rays, scene.frame, packets), plainly(rays, scene.frame));
}

TEST(SimdTracer, FollowTheStepAndTheLutWhereAllSamplesHaveOneLength) {
  Dice dice(11);
  LitScene scene(kSize, 16);
  draw_field(scene, dice);
  Frame& frame = scene.frame;
  frame.jitter = false;
  frame.type = wire::RayType::kIntegrate;
  frame.opacity_threshold = wire::kOpacityOne;
  SimdTracer packets(scene.opacity_correction);
  const auto rays = draw_rays(dice, 200, frame);
  std::uint64_t lut_writes = 0;
  for (const std::uint32_t spacing : {65'536u, 90'000u}) {
    frame.spacing = {spacing, spacing, spacing};
    for (const std::uint32_t step : {32'768u, 65'536u}) {
      frame.step = step;
      for (auto& entry : scene.segmentation) entry.opacity = static_cast<std::uint16_t>(entry.opacity / 2 + 1);
      if (frame.wide) scene.widen();
      ASSERT_TRUE(packets.prepare(1 << 20, frame, ++lut_writes, 1));
      expect_equal(by_vectors(rays, frame, packets), plainly(rays, frame));
      frame.step = step / 2;
      ASSERT_TRUE(packets.prepare(1 << 20, frame, lut_writes, 1));
      expect_equal(by_vectors(rays, frame, packets), plainly(rays, frame));
    }
  }
}

TEST(SimdTracer, AreNotMadeForFewRaysNorForSumsNorForScatteredRaysOfUnevenSteps) {
  Dice dice(3);
  LitScene scene(kSize, 8);
  draw_field(scene, dice);
  scene.frame.type = wire::RayType::kIntegrate;
  scene.frame.jitter = false;
  SimdTracer packets(scene.opacity_correction);
  EXPECT_FALSE(packets.prepare(1, scene.frame, 0, 1));  // a copy of the densities for one ray would be a bad bargain
  EXPECT_TRUE(packets.prepare(scene.volume.stored_blocks(), scene.frame, 0, 1));
  Frame jittered = scene.frame, segments = scene.frame, backprojected = scene.frame;
  jittered.scatter = jittered.jitter = segments.scatter = true;
  segments.type = wire::RayType::kSegment;
  backprojected.type = wire::RayType::kBackproject;
  for (const Frame* frame : {&jittered, &segments, &backprojected}) {
    EXPECT_FALSE(packets.prepare(1 << 20, *frame, 0, 1));
  }
}

}  // namespace
}  // namespace gicube::emu
