#include "gicube/scene/voxeliser.h"

#include "scene/geometry/mesh_distance.h"
#include "scene/geometry/placed_field.h"
#include "test.h"
#include "test_meshes.h"

namespace gicube::scene {
namespace {

constexpr int kSize = 64;
constexpr double kHalf = 0.5 * (kSize - 1);

WorldGrid grid(int size = kSize) { return {{0, 0, 0}, 1, {size, size, size}}; }

std::size_t index(int x, int y, int z) { return static_cast<std::size_t>((z * kSize + y) * kSize + x); }

double density(const VoxelWorld& world, std::size_t i) {
  std::uint16_t word = 0;
  std::memcpy(&word, &world.volume.samples[2 * i], sizeof word);
  return word / kMaxDensity;
}

double total(const VoxelWorld& world) {
  double sum = 0;
  for (std::size_t i = 0; i < world.tags.size(); ++i) sum += density(world, i);
  return sum;
}

PlacedSolid solid(const Shape& shape, const Affine& to_voxels, std::uint8_t tag = 0, bool fog = false) {
  return {fields_of(shape).front(), to_voxels, tag, fog};
}

// In the middle of the grid, `scale` voxels a unit.
Affine middle(double scale) { return compose(translation({kHalf, kHalf, kHalf}), scaling({scale, scale, scale})); }

PlacedSolid slab(double low_x, double high_x, std::uint8_t tag, bool fog = false) {
  return solid(BoxShape{{low_x, -9, -9}, {high_x, 80, 80}}, {}, tag, fog);
}

TEST(Voxeliser, FillsTheVolumeOfASphereAndOfATorus) {
  const double pi = std::numbers::pi;
  EXPECT_NEAR(total(voxelise(grid(), {solid(SphereShape{1}, middle(20))})) / (4 * pi / 3 * 8000), 1, 0.01);
  const Affine turned = compose(middle(20), rotation({1, 2, 3}, 50));
  EXPECT_NEAR(total(voxelise(grid(), {solid(TorusShape{0.8, 0.3}, turned)})) / (2 * pi * pi * 0.8 * 0.09 * 8000), 1,
              0.01);
}

TEST(Voxeliser, FillsTheVolumeOfAnEllipsoidThatIsAStretchedSphere) {
  const Affine map =
      compose(compose(translation({kHalf, kHalf, kHalf}), rotation({0, 1, 1}, 30)), scaling({25, 10, 16}));
  EXPECT_NEAR(total(voxelise(grid(), {solid(SphereShape{1}, map)})) / (4 * std::numbers::pi / 3 * 25 * 10 * 16), 1,
              0.01);
}

// Half as thick as the ramp and less: only the shares of voxels add up to it.
TEST(Voxeliser, FillsTheVolumeOfThinPlatesAndSmallBallsByPartialVolumes) {
  const auto of = [](const PlacedSolid& one, Densities densities) {
    return total(voxelise(grid(), {one}, {}, 0, densities));
  };
  for (const Vec3 half : {Vec3{0.4, 9, 9}, Vec3{1, 9, 9}, Vec3{2, 9, 9}, Vec3{3, 3, 3}}) {
    const PlacedSolid ball = solid(SphereShape{}, compose(translation({32, 32, 32}), scaling(half)));
    const double exact = 4 * std::numbers::pi / 3 * half.x * half.y * half.z;
    EXPECT_NEAR(of(ball, Densities::kPartialVolumes) / exact, 1, 0.01) << half.x;
  }
  // Of a plate the ramp makes (1 + h)^2 / 2, on average of where it lies between the voxels, as voxeliser.h says; here
  // a disc, with more around its rim.
  double by_ramp = 0, by_shares = 0;
  for (const double offset : {0.0, 0.25, 0.5, 0.75}) {
    const PlacedSolid disc =
        solid(CylinderShape{}, compose(translation({32, 32, 32 + offset}), scaling({20, 20, 0.4})));
    by_ramp += of(disc, Densities::kRamp) / 4;
    by_shares += of(disc, Densities::kPartialVolumes) / 4;
  }
  const double face = std::numbers::pi * 400;
  EXPECT_NEAR(by_ramp / (face * 1.4 * 1.4 / 2), 1, 0.06);
  EXPECT_NEAR(by_shares / (face * 0.8), 1, 0.01);
}

TEST(Voxeliser, FillsTheVolumeOfAMesh) {
  const auto distance = std::make_shared<const MeshDistance>(cube_mesh(), "cube");
  const PlacedSolid cube{[distance](Vec3 p) { return distance->at(p); }, compose(middle(12), rotation({1, 1, 0}, 40)),
                         0, false};
  EXPECT_NEAR(total(voxelise(grid(), {cube})) / (24 * 24 * 24), 1, 0.01);
}

TEST(Voxeliser, RisesLinearlyOverTwoVoxelsAndPointsInwards) {
  const Affine map = compose(middle(20), rotation({3, 1, 2}, 70));
  const VoxelWorld world = voxelise(grid(), {solid(SphereShape{1}, map)});
  for (int x = 0; x < kSize; ++x) {
    const Vec3 offset = Vec3{double(x), 30, 25} - Vec3{kHalf, kHalf, kHalf};
    const double distance = length(offset) - 20;
    const std::size_t i = index(x, 30, 25);
    EXPECT_NEAR(density(world, i), std::clamp(0.5 - distance / 2, 0.0, 1.0), 1e-3);
    const Vec3 gradient{world.gradients[3 * i], world.gradients[3 * i + 1], world.gradients[3 * i + 2]};
    if (std::abs(distance) < 2.99) {
      EXPECT_LT(length(gradient + normalise(offset)), 1e-5);
    }
    if (std::abs(distance) > 3.01) {
      EXPECT_EQ(gradient, (Vec3{}));
    }
  }
}

TEST(Voxeliser, SkipsNothingThatADistanceEverywhereWouldFind) {
  const Affine map = compose(compose(middle(18), rotation({1, 0, 2}, 20)), scaling({1.2, 0.5, 1}));
  const PlacedSolid torus = solid(TorusShape{0.9, 0.3}, map);
  const VoxelWorld world = voxelise(grid(), {torus});
  const PlacedField everywhere(torus);
  for (int z = 0; z < kSize; ++z) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double distance = everywhere.distance({double(x), double(y), double(z)}).distance;
        ASSERT_NEAR(density(world, index(x, y, z)), std::clamp(0.5 - distance / 2, 0.0, 1.0), 1e-3);
      }
    }
  }
}

TEST(Voxeliser, GivesAVoxelToTheLastSolidThatHoldsItAndNearAFreeSurfaceToTheNearest) {
  const std::vector<PlacedSolid> both{slab(10.5, 40.5, 1), slab(30.5, 50.5, 2)};
  const VoxelWorld world = voxelise(grid(), both);
  const auto tag = [&](int x) { return int(world.tags[index(x, 32, 32)]); };
  EXPECT_EQ(tag(12), 1);
  EXPECT_EQ(tag(30), 1);
  EXPECT_EQ(tag(31), 2);
  EXPECT_EQ(tag(49), 2);
  EXPECT_EQ(tag(9), 1);
  EXPECT_EQ(tag(52), 2);
  const VoxelWorld swapped = voxelise(grid(), {both[1], both[0]});
  EXPECT_EQ(int(swapped.tags[index(35, 32, 32)]), 1);
}

TEST(Voxeliser, SeesNoSurfaceBetweenSolidsThatOverlap) {
  const VoxelWorld world = voxelise(grid(), {slab(10.5, 40.5, 1), slab(30.5, 50.5, 2)});
  for (int x = 14; x < 47; ++x) {
    EXPECT_EQ(density(world, index(x, 32, 32)), 1);
    EXPECT_EQ(world.gradients[3 * index(x, 32, 32)], 0) << x;
  }
}

TEST(Voxeliser, LetsFogFillWhatSolidsLeaveWhateverTheOrder) {
  const PlacedSolid ball = solid(SphereShape{1}, middle(15), 1);
  const PlacedSolid fog = solid(BoxShape{}, middle(26), 2, true);
  const VoxelWorld world = voxelise(grid(), {ball, fog}), swapped = voxelise(grid(), {fog, ball});
  EXPECT_EQ(world.volume.samples, swapped.volume.samples);
  EXPECT_EQ(world.tags, swapped.tags);
  EXPECT_EQ(world.gradients, swapped.gradients);
  EXPECT_EQ(int(world.tags[index(32, 32, 32)]), 1);
  EXPECT_EQ(density(world, index(32, 32, 32)), 1);
  const std::size_t beside = index(52, 32, 32);  // 5 voxels from the ball
  EXPECT_EQ(int(world.tags[beside]), 2);
  EXPECT_EQ(world.fog_density, kFogBesideSolids);
  EXPECT_NEAR(density(world, beside), kFogBesideSolids, 1e-3);
  EXPECT_EQ(density(world, index(62, 32, 32)), 0);
}

// Samples that show the solid, from density 0.3 on, have its tag and its densities; those of the fog never come that
// far.
TEST(Voxeliser, LeavesASolidInFogItsSurfaceWhereverItLies) {
  for (const double face : {30.0, 30.2, 30.45, 30.7, 30.95}) {
    const VoxelWorld world = voxelise(grid(), {slab(-9, 80, 2, true), slab(face, 80, 1)});
    double before_wall = 0;
    for (int x = 0; x < kSize; ++x) {
      const std::size_t here = index(x, 32, 32);
      const double ramp = std::clamp(0.5 - (face - x) / 2, 0.0, 1.0);
      if (world.tags[here] == 1) {
        EXPECT_NEAR(density(world, here), ramp, 1e-3) << face << " " << x;
      } else {
        EXPECT_LT(x + 0.5, face - 0.4 + 1e-9) << face;
        EXPECT_LE(density(world, here), kFogDensity + 1e-3);
        before_wall = density(world, here);
      }
    }
    EXPECT_GT(before_wall, 0.7 * kFogBesideSolids);
    EXPECT_NEAR(density(world, index(5, 32, 32)), kFogBesideSolids, 1e-3);
  }
}

TEST(Voxeliser, IsTheSameForAnyNumberOfThreads) {
  const std::vector<PlacedSolid> solids{solid(TorusShape{1, 0.4}, middle(20), 1), slab(0, 9, 2), slab(20, 60, 3, true)};
  const VoxelWorld one = voxelise(grid(), solids, {}, 1), many = voxelise(grid(), solids, {}, 5);
  EXPECT_EQ(one.volume.samples, many.volume.samples);
  EXPECT_EQ(one.tags, many.tags);
  EXPECT_EQ(one.gradients, many.gradients);
}

TEST(Voxeliser, LeavesScansWhatSolidsDoNotFill) {
  PlacedScan scan;  // rises along x
  scan.density = [](Vec3 p) { return p.x / 100; };
  scan.low = {10, 10, 10};
  scan.high = {50, 50, 50};
  scan.tag = 3;
  scan.visible = 0.3;
  const VoxelWorld world = voxelise(grid(), {slab(40.5, 60.5, 1), slab(0, 36, 2, true)}, {scan});
  EXPECT_EQ(int(world.tags[index(45, 30, 30)]), 1);
  EXPECT_EQ(int(world.tags[index(33, 30, 30)]), 3);  // visible: not the fog's
  EXPECT_NEAR(density(world, index(33, 30, 30)), 0.33, 1e-3);
  EXPECT_EQ(int(world.tags[index(20, 30, 30)]), 2);
  EXPECT_NEAR(density(world, index(20, 30, 30)), kFogDensity, 1e-3);
  EXPECT_EQ(world.gradients[3 * index(33, 30, 30)], 1);
  EXPECT_EQ(density(world, index(33, 9, 30)), density(world, index(33, 2, 2)));  // the fog beside the box
}

}  // namespace
}  // namespace gicube::scene
