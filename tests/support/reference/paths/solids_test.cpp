// Sharp surfaces against planes, corners and a scan through fields that are not linear.
#include "solids.h"

#include <functional>
#include <numbers>

#include "path_tests.h"

namespace gicube::reference::paths {
namespace {

struct Solid {
  Solid(Dims dims, const std::function<double(Vec3)>& value, double level) : test(dims, value) {
    test.surface(level);
    scene = path_scene(test, {.scattering = 0.6, .bsdf = Bsdf::kDiffuse});
    scene.surfaces[0] = level;
  }
  TestScene test;
  PathScene scene;
};

TEST(Solids, BeginWhereAPlaneIs) {
  const Vec3 slope{0.02, 0.03, 0.05};
  const Solid solid(
      {17, 17, 17}, [&](Vec3 p) { return dot(slope, p); }, 0.8);
  const Field field(solid.scene.scene.volume, {});
  const Solids solids(solid.scene, field);
  CounterRandom random(50, 0);
  for (int i = 0; i < 200; ++i) {
    const Vec3 from{4 * random.uniform(), 4 * random.uniform(), 4 * random.uniform()};
    const Vec3 to{12 + 4 * random.uniform(), 12 + 4 * random.uniform(), 12 + 4 * random.uniform()};
    const double truth = (0.8 - dot(slope, from)) / dot(slope, to - from);
    const auto in = solids.crossing(from, to - from, 0, 1, false);
    ASSERT_TRUE(in);
    EXPECT_NEAR(in->distance, truth, 1e-6);  // voxels are floats
    EXPECT_NEAR(length(normalise(in->normal) + normalise(slope)), 0, 1e-5);
    const auto out = solids.crossing(to, from - to, 0, 1, true);
    ASSERT_TRUE(out);
    EXPECT_NEAR(out->distance, 1 - truth, 1e-6);
    EXPECT_FALSE(solids.crossing(from, to - from, 0, 0.99 * truth, false));
  }
}

// However short the part of a ray is that lies in the solid: steps would miss it.
TEST(Solids, AreMetWhereAFineScanOfTheFieldMeetsThem) {
  const Solid solid(
      {12, 12, 12}, [](Vec3 p) { return 0.5 + 0.5 * std::sin(2 * p.x + p.y * p.z); }, 0.85);
  const Field field(solid.scene.scene.volume, {});
  const Solids solids(solid.scene, field);
  CounterRandom random(51, 0);
  int met = 0;
  for (int i = 0; i < 100; ++i) {
    const auto place = [&] { return Vec3{11 * random.uniform(), 11 * random.uniform(), 11 * random.uniform()}; };
    const Vec3 from = place(), way = place() - from;
    const bool inside = field.sample(from).value >= 0.85;
    const auto found = solids.crossing(from, way, 0, 1, inside);
    constexpr int kSteps = 200'000;
    double truth = 2;
    for (int k = 1; k <= kSteps && truth > 1; ++k) {
      const double t = static_cast<double>(k) / kSteps;
      if ((field.sample(from + t * way).value >= 0.85) != inside) truth = t;
    }
    ASSERT_EQ(found.has_value(), truth <= 1) << i;
    if (!found) continue;
    EXPECT_NEAR(found->distance, truth, 2.0 / kSteps) << i;
    ++met;
  }
  EXPECT_GT(met, 30);
}

TEST(Solids, HaveTheLightOfALampToTheDigit) {
  Solid solid(
      {17, 17, 17}, [](Vec3 p) { return p.z / 16; }, 0.5);
  for (const double reach : {0.0, 0.5}) {
    PathScene scene = solid.scene;
    scene.normal_reach = reach;
    add_light(scene, PointLight{{11, 8, 4}, 50});  // 5 away, cosine 4/5
    const auto found = PathTracer(scene).estimate({8, 8, -9}, kAhead, 50, 37);
    EXPECT_NEAR(found[0].mean, 0.6 * 50 * 0.8 / (4 * 25 * std::pow(std::numbers::pi, 2)), 1e-9);
    EXPECT_NEAR(found[0].error, 0, 1e-12);
  }
}

// Furnaces: see path_tracer_test.cpp.
TEST(Solids, ShowNothingOfWhatAbsorbsNothing) {
  Solid solid(
      {20, 20, 20},
      [](Vec3 p) {
        return std::max(0.0, 1 - length(p - Vec3{9.5, 9.5, 9.5}) / 9);
      },
      0.4);
  const std::vector<Material> materials{{.scattering = 1, .bsdf = Bsdf::kDiffuse},
                                        {.scattering = 1, .bsdf = Bsdf::kSpecular},
                                        {.scattering = 1, .bsdf = Bsdf::kTrap, .surface = true, .parameters = {1.5F}}};
  for (const Material& material : materials) {
    PathScene scene = solid.scene;
    scene.materials[0] = material;
    scene.environment = [](Vec3) { return Rgb{1, 2, 3}; };
    const PathTracer tracer(scene);
    for (std::uint64_t i = 0; i < 200; ++i) {
      CounterRandom random(34, i);
      const Vec3 from = Vec3{9.5, 9.5, 9.5} + 30 * random.direction();
      const Rgb found = tracer.radiance(from, Vec3{9.5, 9.5, 9.5} - from, random);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(found[c], 1.0 + static_cast<double>(c), 1e-9);
    }
  }
}

TEST(Solids, OfGlassReflectWhatBothFacesOfAPlateDo) {
  Solid solid(
      {9, 9, 33}, [](Vec3 p) { return std::clamp(std::min(p.z - 8, 24 - p.z) / 4, 0.0, 1.0); }, 0.4);
  solid.scene.materials[0] = {.scattering = 1, .bsdf = Bsdf::kTrap, .surface = true, .parameters = {1.5F}};
  solid.scene.environment = [](Vec3 direction) {
    return Rgb{direction.z < 0 ? 1.0 : 0.0, direction.z > 0 ? 1.0 : 0.0, 0};
  };
  const auto shares = PathTracer(solid.scene).estimate({4, 4, -1}, kAhead, 40000, 40);
  expect_near(shares[0], 0.08 / 1.04, "reflected");
  expect_near(shares[1], 0.96 / 1.04, "transmitted");
}

}  // namespace
}  // namespace gicube::reference::paths
