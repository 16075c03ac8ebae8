#include "form_factors/radiosity/field.h"

#include "test.h"

namespace gicube::samples {
namespace {

constexpr int kSize = 40;

// A solution in which every face between the open and the solid voxels of `solid` gets `light(normal)`, in space that
// holds nothing else.
template <typename Solid, typename Light>
RadiosityResult faces_of(const Solid& solid, const Light& light) {
  RadiosityResult result;
  for (int z = 1; z + 1 < kSize; ++z) {
    for (int y = 1; y + 1 < kSize; ++y) {
      for (int x = 1; x + 1 < kSize; ++x) {
        if (solid(x, y, z)) continue;
        for (std::uint8_t facing = 0; facing < 6; ++facing) {
          Leaf leaf;
          leaf.cell = {x, y, z};
          leaf.facing = facing;
          leaf.weight = 1;
          const auto [bx, by, bz] = voxel_behind(leaf);
          if (!solid(bx, by, bz)) continue;
          result.leaves.push_back(leaf);
          Vec3 normal;
          (facing / 2 == 0 ? normal.x : facing / 2 == 1 ? normal.y : normal.z) = facing % 2 == 0 ? -1 : 1;
          const double h = light(normal);
          result.incident.push_back({h, h / 2, 0});
        }
      }
    }
  }
  return result;
}

SceneSetup empty_setup() {
  SceneSetup setup;
  setup.volume.dims = {kSize, kSize, kSize};
  return setup;
}

std::size_t at(int x, int y, int z) { return static_cast<std::size_t>(x + kSize * (y + kSize * z)); }

constexpr double kMiddle = 19.5, kRadius = 14;

bool in_ball(int x, int y, int z) { return std::hypot(x - kMiddle, y - kMiddle, z - kMiddle) < kRadius; }

// Light from one side: a face gets the cosine at its axis, the surface behind the staircase should get that at its
// normal.
TEST(Field, ABallsLightIsThatOfItsSurfaceAndNotThatOfItsStairs) {
  const Vec3 towards = normalise({1, 0.7, 0.5});
  const RadiosityResult result = faces_of(in_ball, [&](Vec3 n) { return std::max(0.0, dot(n, towards)); });
  SceneSetup with_normals = empty_setup();
  with_normals.gradients.resize(3 * kSize * kSize * kSize);
  for (int i = 0; i < kSize * kSize * kSize; ++i) {
    const int x = i % kSize, y = i / kSize % kSize, z = i / (kSize * kSize);
    const Vec3 inward = normalise({kMiddle - x, kMiddle - y, kMiddle - z});
    const auto place = 3 * static_cast<std::size_t>(i);
    with_normals.gradients[place] = static_cast<float>(inward.x);
    with_normals.gradients[place + 1] = static_cast<float>(inward.y);
    with_normals.gradients[place + 2] = static_cast<float>(inward.z);
  }
  for (const bool normals : {true, false}) {
    const LightField field = field_of(result, normals ? with_normals : empty_setup());
    double sum = 0, errors = 0, stairs = 0;
    int count = 0;
    for (const Leaf& leaf : result.leaves) {
      const auto [x, y, z] = voxel_behind(leaf);
      const Vec3 n = normalise({x - kMiddle, y - kMiddle, z - kMiddle});
      if (std::min({n.x, n.y, n.z}) < 0.05) continue;  // there the light meets none of its faces from behind
      const double seen = field.values[3 * at(x, y, z)], meant = dot(n, towards);
      EXPECT_NEAR(field.values[3 * at(x, y, z) + 1], seen / 2, 1e-6);
      sum += seen - meant;
      errors += (seen - meant) * (seen - meant);
      stairs += meant / (n.x + n.y + n.z) - meant;  // flux over the stairs' own area
      ++count;
    }
    ASSERT_GT(count, 300);
    EXPECT_LT(std::abs(sum / count), normals ? 0.025 : 0.03) << normals;
    EXPECT_LT(std::sqrt(errors / count), normals ? 0.04 : 0.06) << normals;
    RecordProperty(normals ? "bias_with_normals" : "bias", std::to_string(sum / count));
    RecordProperty(normals ? "rms_with_normals" : "rms", std::to_string(std::sqrt(errors / count)));
    EXPECT_LT(stairs / count, -0.25);  // what is mended
  }
}

TEST(Field, OfAFlatWallIsItsFacesOwnAndReachesTheVoxelsAround) {
  const auto floor = [](int, int, int z) { return z < 10; };
  const LightField field = field_of(faces_of(floor, [](Vec3 n) { return n.z > 0 ? 3.0 : 0.0; }), empty_setup());
  ASSERT_EQ(field.channels, 3);
  for (const int z : {8, 9, 10}) EXPECT_NEAR(field.values[3 * at(20, 20, z)], 3, 1e-6) << z;
  EXPECT_EQ(field.values[3 * at(20, 20, 13)], 0);
  EXPECT_EQ(field.values[3 * at(20, 20, 5)], 0);
}

TEST(Field, BothSidesOfAWallKeepTheirOwnLight) {
  const auto wall = [](int, int, int z) { return z >= 10 && z < 14; };
  const LightField field = field_of(faces_of(wall, [](Vec3 n) { return n.z > 0 ? 3.0 : 1.0; }), empty_setup());
  EXPECT_NEAR(field.values[3 * at(20, 20, 13)], 3, 1e-6);
  EXPECT_NEAR(field.values[3 * at(20, 20, 10)], 1, 1e-6);
}

TEST(Field, EmittersGlowAndMediumHasItsOwnLightButBesideASurface) {
  const auto floor = [](int, int, int z) { return z < 10; };
  RadiosityResult result = faces_of(floor, [](Vec3 n) { return n.z > 0 ? 3.0 : 0.0; });
  for (Leaf& leaf : result.leaves) leaf.emission = {5, 0, 0};
  for (int z = 10; z < kSize; ++z) {
    Leaf medium;
    medium.facing = kMedium;
    medium.cell = {20, 20, z};
    medium.weight = 0.04;
    result.leaves.push_back(medium);
    result.incident.push_back({0.5, 0.25, 0});
  }
  const LightField field = field_of(result, empty_setup());
  EXPECT_NEAR(field.values[3 * at(20, 20, 9)], 8, 1e-5);
  EXPECT_NEAR(field.values[3 * at(20, 20, 9) + 1], 1.5, 1e-5);
  EXPECT_NEAR(field.values[3 * at(20, 20, 10)], 8, 1e-5);
  for (const int z : {11, 20}) EXPECT_NEAR(field.values[3 * at(20, 20, z)], 0.5, 1e-6) << z;
}

}  // namespace
}  // namespace gicube::samples
