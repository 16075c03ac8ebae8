// Free paths and transmittances against the law of Beer and Lambert.
#include "extinction.h"

#include "path_tests.h"

namespace gicube::reference::paths {
namespace {

// The share of paths without a collision.
Estimate escaping(const PathScene& scene, Vec3 origin, Vec3 direction, int paths, std::uint64_t seed) {
  const Field field(scene.scene.volume, {});
  const Extinction extinction(scene, field);
  double escaped = 0;
  for (int i = 0; i < paths; ++i) {
    CounterRandom random(seed, static_cast<std::uint64_t>(i));
    if (!extinction.collide({extinction.place_of(origin), normalise(direction)}, INFINITY, random)) ++escaped;
  }
  const double share = escaped / paths;
  return {share, std::sqrt(share * (1 - share) / paths)};
}

Estimate passing(const PathScene& scene, Vec3 origin, Vec3 direction, double distance, int paths, std::uint64_t seed) {
  const Field field(scene.scene.volume, {});
  const Extinction extinction(scene, field);
  double sum = 0, squares = 0;
  for (int i = 0; i < paths; ++i) {
    CounterRandom random(seed, static_cast<std::uint64_t>(i));
    const double one = extinction.transmittance({extinction.place_of(origin), normalise(direction)}, distance, random);
    sum += one, squares += one * one;
  }
  const double mean = sum / paths;
  return {mean, std::sqrt((squares / paths - mean * mean) / paths)};
}

TEST(FreePaths, EscapeASlabAsBeerAndLambertSay) {
  UniformScene test({9, 9, 33});
  for (const double tau : {0.1, 1.0, 4.0}) {
    test.look(1 - std::exp(-tau / 32));
    const PathScene scene = path_scene(test, isotropic(1));
    expect_near(escaping(scene, {4, 4, -3}, kAhead, 40000, 1), std::exp(-tau), "straight");
    expect_near(escaping(scene, {4, 1, 0}, {0, 6, 32}, 40000, 2), std::exp(-tau * std::sqrt(1 + 36.0 / 1024)),
                "oblique");
  }
}

TEST(FreePaths, HaveThePlacesOfTheExponentialLaw) {
  UniformScene test({9, 9, 33});
  test.look(1 - std::exp(-0.1));
  const PathScene scene = path_scene(test, isotropic(1));
  const Field field(scene.scene.volume, {});
  const Extinction extinction(scene, field);
  constexpr int kPaths = 40000;
  int near = 0, middle = 0;
  for (std::uint64_t i = 0; i < kPaths; ++i) {
    CounterRandom random(3, i);
    const auto collision = extinction.collide({{4, 4, 0}, kAhead}, 32, random);
    near += collision && collision->position.z < 5 ? 1 : 0;
    middle += collision && collision->position.z >= 5 && collision->position.z < 12.5 ? 1 : 0;
  }
  const auto share = [](int count) {
    const double p = count / double{kPaths};
    return Estimate{p, std::sqrt(p * (1 - p) / kPaths)};
  };
  expect_near(share(near), 1 - std::exp(-0.5), "within 5 voxels");
  expect_near(share(middle), std::exp(-0.5) - std::exp(-1.25), "from 5 to 12.5");
}

// Where the opacity grows linearly from 0 to p over the length L, the depth is the integral of -ln(1 - a).
TEST(Tracking, FindsTheIntegralOfARamp) {
  TestScene test({9, 9, 33}, [](Vec3 p) { return p.z / 32; });
  constexpr double kMost = 0.2;
  test.scene.functions[0] = {{{0, {1, 1, 1}}}, {{0, 0}, {1, kMost}}};
  const PathScene scene = path_scene(test, isotropic(1));
  const double truth = std::exp(-32 / kMost * ((1 - kMost) * std::log(1 - kMost) + kMost));
  expect_near(escaping(scene, {4, 4, -1}, kAhead, 40000, 4), truth, "delta tracking");
  expect_near(passing(scene, {4, 4, 0}, kAhead, 32, 40000, 5), truth, "ratio tracking");
  expect_near(passing(scene, {4, 4, 32}, {0, 0, -1}, 32, 40000, 6), truth, "backwards");
}

// A step of the transfer function within a voxel, and two tags.
TEST(Tracking, KnowsStepsAndTags) {
  TestScene test({9, 9, 17}, [](Vec3 p) { return p.z / 16; });
  std::vector<std::uint8_t> tags(9 * 9 * 17, 0);
  for (std::size_t i = 9 * 9 * 8; i < tags.size(); ++i) tags[i] = 2;  // from z = 7.5 on
  test.scene.volume.tags = tags;
  test.scene.functions[0] = {{{0, {1, 1, 1}}}, {{5.3 / 16, 0}, {5.3 / 16, 0.4}}};
  test.scene.functions[2] = {{{0, {1, 1, 1}}}, {{0, 0.1}}};
  const PathScene scene = path_scene(test, isotropic(1));
  const double truth = std::pow(0.6, 7.5 - 5.3) * std::pow(0.9, 16 - 7.5);
  expect_near(escaping(scene, {4, 4, 0}, kAhead, 40000, 7), truth, "delta tracking");
  expect_near(passing(scene, {4, 4, 0}, kAhead, 16, 40000, 8), truth, "ratio tracking");
}

TEST(Tracking, CountsPhysicalLength) {
  UniformScene test({9, 9, 17});
  test.look(0.03);
  test.scene.volume.spacing = {0.5, 0.5, 1};
  const PathScene scene = path_scene(test, isotropic(1));
  expect_near(escaping(scene, {4, 4, 0}, kAhead, 40000, 9), std::pow(0.97, 32), "along z");
  expect_near(escaping(scene, {4, 0, 0}, {0, 8, 16}, 40000, 10), std::pow(0.97, 8 * std::sqrt(5.0)), "oblique");
}

TEST(Tracking, EndsAtCutPlanes) {
  UniformScene test({9, 9, 33});
  test.look(0.1);
  test.scene.view.cut_planes = {{{0, 0, -2}, -31}};  // keeps z <= 15.5
  expect_near(escaping(path_scene(test, isotropic(1)), {4, 4, -2}, kAhead, 40000, 11), std::pow(0.9, 15.5), "cut");
}

TEST(Tracking, StopsRaysAtWhatIsOpaqueAndLetsThemLeaveIt) {
  TestScene test({9, 9, 17}, [](Vec3 p) { return p.z / 16; });
  test.surface(0.5);
  const PathScene scene = path_scene(test, {.scattering = 1, .bsdf = Bsdf::kDiffuse});
  const Field field(scene.scene.volume, {});
  const Extinction extinction(scene, field);
  for (std::uint64_t i = 0; i < 100; ++i) {
    CounterRandom random(12, i);
    const auto hit = extinction.collide({{4, 4, 0}, kAhead}, INFINITY, random);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->position.z, 8, 1);  // the surface is as soft as PathScene::max_extinction says
    EXPECT_GE(hit->position.z, 8);
    EXPECT_EQ(extinction.transmittance({{4, 4, 9}, {0, 0, -1}, true}, 9, random), 1);
    EXPECT_EQ(extinction.transmittance({{4, 4, 2}, kAhead, true}, 14, random), 0);
    EXPECT_LT(extinction.transmittance({{4, 4, 9}, {0, 0, -1}, false}, 9, random), 0.1);
  }
}

}  // namespace
}  // namespace gicube::reference::paths
