// Fog beside solids, as rays through the voxels see it, against lengths in the scene's own shapes.
#include "gicube/scene/world.h"
#include "test.h"

namespace gicube::scene {
namespace {

constexpr std::uint8_t kWall = 0, kFog = 1;

// The board's rules in doubles: a sample has the interpolated density, and the tag of the nearest voxel.
class Sampled {
 public:
  Sampled(const Node& solids, Vec3 half, int size, double extinction) {
    World world{.low = -1 * half, .high = half, .size = size, .root = {}};
    Node fog{.content = Shape(BoxShape{{-9, -9, -9}, {9, 9, 9}}), .material = "fog"};
    world.root.children = {solids, fog};
    std::vector<SceneMaterial> materials(2);
    materials[kWall] = {.name = "wall", .tag = kWall, .look = SolidLook{}};
    materials[kFog] = {.name = "fog", .tag = kFog, .look = FogLook{{1, 1, 1}, extinction}};
    built_ = build(world, materials);
  }

  double voxel() const { return built_.grid.voxel; }
  // Per world unit; nothing beyond the surface that lies at half of a solid's density.
  double extinction(Vec3 place) const {
    const Vec3 v = built_.grid.voxel_of(place);
    if (tag(v) != kFog) return 0;
    return -std::log1p(-built_.looks[kFog].function.opacity_at(density(v))) / voxel();
  }
  double depth(Vec3 from, Vec3 direction, double length) const {
    const int steps = static_cast<int>(std::ceil(16 * length / voxel()));
    double sum = 0;
    for (int i = 0; i < steps; ++i) sum += extinction(from + ((i + 0.5) / steps * length) * direction);
    return sum * length / steps;
  }

 private:
  std::size_t at(int x, int y, int z) const {
    const Dims& d = built_.grid.dims;
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(d[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(d[0]) +
           static_cast<std::size_t>(x);
  }
  int held(double v, std::size_t axis) const { return std::clamp(static_cast<int>(v), 0, built_.grid.dims[axis] - 1); }
  int tag(Vec3 v) const { return built_.voxels.tags[at(held(v.x + 0.5, 0), held(v.y + 0.5, 1), held(v.z + 0.5, 2))]; }
  double density(Vec3 v) const {
    double sum = 0;
    const std::array<double, 3> way{v.x - std::floor(v.x), v.y - std::floor(v.y), v.z - std::floor(v.z)};
    for (int corner = 0; corner < 8; ++corner) {
      const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      std::uint16_t word = 0;
      std::memcpy(&word, &built_.voxels.volume.samples[2 * at(held(v.x + x, 0), held(v.y + y, 1), held(v.z + z, 2))],
                  sizeof word);
      sum += word * (x != 0 ? way[0] : 1 - way[0]) * (y != 0 ? way[1] : 1 - way[1]) * (z != 0 ? way[2] : 1 - way[2]);
    }
    return sum;
  }

  BuiltWorld built_;
};

Node box(Vec3 low, Vec3 high) { return {.content = Shape(BoxShape{low, high}), .material = "wall"}; }

// Space from low_x to high_x that two walls leave, as wide as the world.
Node two_walls(double low_x, double high_x) {
  Node walls;
  walls.children = {box({-9, -9, -9}, {low_x, 9, 9}), box({high_x, -9, -9}, {9, 9, 9})};
  return walls;
}

TEST(FogBesideSolids, IsWholeAlongAnAxisWhereverWallsLieBetweenTheVoxels) {
  for (const int size : {15, 29}) {
    for (int place = 0; place < 10; ++place) {
      const double shift = place / 10.0 * 2 / (size - 1), low = -0.7 + shift, length = 1.33;
      const Sampled sampled(two_walls(low, low + length), {1, 1, 1}, size, 0.7);
      const double depth = sampled.depth({-1, 0.03, -0.02}, {1, 0, 0}, 2);
      EXPECT_NEAR(depth / (0.7 * length), 1, 0.005) << size << " voxels, " << place;
    }
  }
}

TEST(FogBesideSolids, IsWholeBetweenTurnedWallsOnAverageOverThem) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> even(0, 1);
  for (int i = 0; i < 4; ++i) {
    const Rotate turn{{even(random) - 0.5, even(random) - 0.5, even(random) - 0.5}, 360 * even(random)};
    Node walls = two_walls(-0.6, 0.6);
    walls.transforms = {turn};
    const Sampled sampled(walls, {1, 1, 1}, 29, 0.7);
    const Affine map = map_of({turn});
    double depth = 0;
    constexpr int kLines = 400;
    for (int line = 0; line < kLines; ++line) {
      const Vec3 from{-0.9, 0.6 * even(random) - 0.3, 0.6 * even(random) - 0.3};
      depth += sampled.depth(map.point(from), map.vector({1, 0, 0}), 1.8) / kLines;
    }
    EXPECT_NEAR(depth / (0.7 * 1.2), 1, 0.01) << i;
  }
}

// What a lamp's light loses on its way to the walls of a closed room of 14 x 12 x 10 voxels, and of twice as many.
TEST(FogBesideSolids, OfAClosedRoomTakesWhatItTakesOfALampsLight) {
  constexpr Vec3 kHalf{0.7, 0.6, 0.5}, kLamp{0.15, 0.1, 0.2};
  Node walls;
  walls.children = {two_walls(-kHalf.x, kHalf.x), box({-9, -9, -9}, {9, -kHalf.y, 9}),
                    box({-9, kHalf.y, -9}, {9, 9, 9}), box({-9, -9, -9}, {9, 9, -kHalf.z}),
                    box({-9, -9, kHalf.z}, {9, 9, 9})};
  for (const double extinction : {0.7, 3.0}) {
    for (const int size : {19, 37}) {
      const Sampled sampled(walls, {0.9, 0.9, 0.9}, size, extinction);
      std::mt19937 random(2);
      std::uniform_real_distribution<double> even(0, 1);
      double through = 0, expected = 0, volume = 0;
      constexpr int kRays = 4000;
      for (int i = 0; i < kRays; ++i) {
        const double z = 1 - 2 * (i + 0.5) / kRays, turn = 2 * std::numbers::pi * even(random),
                     ring = std::sqrt(1 - z * z);
        const Vec3 d{ring * std::cos(turn), ring * std::sin(turn), z};
        const auto way = [](double at, double along, double half) { return ((along > 0 ? half : -half) - at) / along; };
        const double length =
            std::min({way(kLamp.x, d.x, kHalf.x), way(kLamp.y, d.y, kHalf.y), way(kLamp.z, d.z, kHalf.z)});
        expected += std::exp(-extinction * length) / kRays;
        through += std::exp(-sampled.depth(kLamp, d, length)) / kRays;
      }
      constexpr int kPlaces = 60;
      for (int i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
        const auto at = [&](int k) { return ((k % kPlaces + even(random)) / kPlaces - 0.5) * 1.8; };
        volume += sampled.extinction({at(i), at(i / kPlaces), at(i / kPlaces / kPlaces)});
      }
      volume *= std::pow(1.8 / kPlaces, 3) / extinction;
      EXPECT_NEAR((1 - through) / (1 - expected), 1, size == 19 ? 0.01 : 0.003) << extinction << " " << size;
      EXPECT_NEAR(volume / (1.4 * 1.2 * 1.0), 1, 0.01) << extinction << " " << size;
    }
  }
}

// Where no solid stands in it, a fog's densities and look are those of a world without solids.
TEST(FogBesideSolids, IsThatOfAWorldWithoutSolidsWhereNoneIsNear) {
  std::vector<SceneMaterial> materials(2);
  materials[kWall] = {.name = "wall", .tag = kWall, .look = SolidLook{}};
  materials[kFog] = {.name = "fog", .tag = kFog, .look = FogLook{{1, 1, 1}, 2}};
  const Node fog{.content = Shape(BoxShape{{-0.8, -0.8, -0.8}, {0, 0, 0}}), .material = "fog"};
  World alone{.size = 21, .root = {}}, apart = alone;
  alone.root.children = {fog};
  apart.root.children = {fog, box({0.6, 0.6, 0.6}, {0.9, 0.9, 0.9})};
  const BuiltWorld a = build(alone, materials), b = build(apart, materials);
  EXPECT_EQ(b.voxels.fog_density, kFogDensity);
  EXPECT_EQ(b.looks[kFog].function.opacities.size(), 2u);
  for (std::size_t i = 0; i < a.voxels.tags.size(); ++i) {
    if (a.voxels.tags[i] != kFog) continue;
    EXPECT_EQ(std::memcmp(&a.voxels.volume.samples[2 * i], &b.voxels.volume.samples[2 * i], 2), 0) << i;
  }
}

}  // namespace
}  // namespace gicube::scene
