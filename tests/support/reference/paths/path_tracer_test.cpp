// The path tracer against what the literature and closed forms say of light in media and at walls.
#include "path_tracer.h"

#include <algorithm>
#include <numbers>
#include <optional>

#include "path_tests.h"
#include "reference/slab_table.h"

namespace gicube::reference::paths {
namespace {

constexpr double kPi = std::numbers::pi;

// A slab across z of this optical thickness, one voxel thick and far wider than light goes. Light that comes from where
// a reversed path ends is as much as light that goes there [reciprocity]: the share of an eye's paths that leave by a
// face is that of a beam's light.
class Slab {
 public:
  Slab(double optical_thickness, const Material& material) : test_({160, 160, 2}) {
    test_.look(1 - std::exp(-optical_thickness));
    scene_ = path_scene(test_, material);
    scene_.environment = [](Vec3 direction) {
      return Rgb{direction.z < 0 ? 1.0 : 0.0, direction.z > 0 ? 1.0 : 0.0, 0};
    };
    tracer_.emplace(scene_);
  }
  // Channel 0 what is reflected, channel 1 what is transmitted.
  std::array<Estimate, 3> shares(std::uint64_t paths, std::uint64_t seed) const {
    return tracer_->estimate({79.5, 79.5, -1}, kAhead, paths, seed);
  }

 private:
  UniformScene test_;
  PathScene scene_;
  std::optional<PathTracer> tracer_;
};

TEST(PathTracer, FindsTheSlabTable) {
  for (const SlabRow& row : kSlabTable) {
    const auto shares = Slab(row.optical_thickness, isotropic(row.albedo)).shares(20000, 31);
    const std::string name = std::to_string(row.optical_thickness) + " thick, albedo " + std::to_string(row.albedo);
    expect_near(shares[0], row.reflected, (name + " reflected").c_str(), 1e-4);
    expect_near(shares[1], row.transmitted, (name + " transmitted").c_str(), 1e-4);
  }
}

// Van de Hulst, Multiple Light Scattering, 1980, table 35; as quoted by Wang, Jacques and Zheng 1995 (MCML), table 3.1.
TEST(PathTracer, FindsVanDeHulstsForwardScatteringSlab) {
  const auto shares = Slab(2, forward(0.9, 0.75F)).shares(40000, 32);
  expect_near(shares[0], 0.09739, "reflected");
  expect_near(shares[1], 0.66096, "transmitted");
}

// Chandrasekhar's H function of isotropic scattering, by iteration (Radiative Transfer, 1950, chapter V).
class HFunction {
 public:
  explicit HFunction(double albedo) : albedo_(albedo), values_(kPoints, 1) {
    for (int round = 0; round < 400; ++round) {
      std::vector<double> next(kPoints);
      for (int i = 0; i < kPoints; ++i) next[static_cast<std::size_t>(i)] = at(place(i));
      values_ = next;
    }
  }
  double at(double mu) const {
    double integral = 0;
    for (int i = 0; i < kPoints; ++i) integral += place(i) * values_[static_cast<std::size_t>(i)] / (mu + place(i));
    return 1 / (std::sqrt(1 - albedo_) + albedo_ / 2 * integral / kPoints);
  }

 private:
  static constexpr int kPoints = 400;
  static double place(int i) { return (i + 0.5) / kPoints; }
  double albedo_;
  std::vector<double> values_;
};

TEST(PathTracer, FindsTheRadianceOfAHalfSpaceByTheHFunction) {
  UniformScene test({128, 128, 65});
  test.look(1 - std::exp(-2.0));  // 128 mean free paths deep, 127 to each side
  for (const auto& [albedo, mu, mu0] :
       {std::array{0.5, 1.0, 1.0}, {0.8, 0.6, 1.0}, {0.9, 1.0, 0.5}, {0.99, 0.8, 0.6}}) {
    PathScene scene = path_scene(test, isotropic(albedo));
    add_light(scene, DirectionalLight{{std::sqrt(1 - mu0 * mu0), 0, -mu0}, 10});
    const Vec3 direction{0, std::sqrt(1 - mu * mu), mu};
    const HFunction h(albedo);
    const double truth = 10 / kPi * albedo / 4 * mu0 / (mu + mu0) * h.at(mu) * h.at(mu0);
    const auto found = PathTracer(scene).estimate(Vec3{63.5, 63.5, 0} - 9 * direction, direction, 10000, 33);
    expect_near(found[0], truth, ("albedo " + std::to_string(albedo)).c_str(), 1e-4 * truth);
  }
}

// In light that is 1 from everywhere, what absorbs nothing shows 1, whatever its shape: each single path does.
TEST(Furnace, ShowsNothingOfWhatDoesNotAbsorb) {
  TestScene test({20, 20, 20}, [](Vec3 p) { return std::max(0.0, 1 - length(p - Vec3{9.5, 9.5, 9.5}) / 9); });
  const Material glass{.scattering = 1, .bsdf = Bsdf::kTrap, .surface = true, .parameters = {1.5F}};
  const std::vector<std::pair<const char*, Material>> materials{
      {"isotropic", isotropic(1)},
      {"forward", forward(1, 0.8F)},
      {"diffuse", {.scattering = 1, .bsdf = Bsdf::kDiffuse}},
      {"mirror", {.scattering = 1, .bsdf = Bsdf::kSpecular}},
      {"gloss", {.scattering = 1, .bsdf = Bsdf::kDullReflection, .gloss = 0.5}},
      {"glass", glass}};
  for (const auto& [name, material] : materials) {
    test.surface(0.4);
    if (material.surface) test.scene.functions[0].opacities = {{0.4, 0}, {0.4, 1}, {0.5, 1}, {0.5, 0}};
    if (material.bsdf == Bsdf::kIsotropic || material.bsdf == Bsdf::kTrap) test.scene.volume.spacing = {1, 2, 1};
    if (material.bsdf == Bsdf::kIsotropic) test.look(0.2);
    PathScene scene = path_scene(test, material);
    scene.environment = [](Vec3) { return Rgb{1, 2, 3}; };
    const PathTracer tracer(scene);
    for (std::uint64_t i = 0; i < 200; ++i) {
      CounterRandom random(34, i);
      const Vec3 from = Vec3{9.5, 9.5, 9.5} + 30 * random.direction();
      const Rgb found = tracer.radiance(from, Vec3{9.5, 9.5, 9.5} - from, random);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(found[c], 1.0 + static_cast<double>(c), 1e-9) << name;
    }
  }
}

// The same light from lamps, which are connected with: six squares make a closed box, with radiance 1 within.
TEST(Furnace, IsTheSameByConnectionsWithLamps) {
  TestScene test({20, 20, 20}, [](Vec3 p) { return std::max(0.0, 1 - length(p - Vec3{9.5, 9.5, 9.5}) / 9); });
  const auto closed = [&test](const Material& material) {
    PathScene scene = path_scene(test, material);
    scene.sees_lights = true;
    const double e = 60, low = 9.5 - e / 2, high = 9.5 + e / 2, power = kPi * e * e;
    add_light(scene, RectangleLight{{low, low, low}, {e, 0, 0}, {0, e, 0}, power});
    add_light(scene, RectangleLight{{low, low, high}, {0, e, 0}, {e, 0, 0}, power});
    add_light(scene, RectangleLight{{low, low, low}, {0, e, 0}, {0, 0, e}, power});
    add_light(scene, RectangleLight{{high, low, low}, {0, 0, e}, {0, e, 0}, power});
    add_light(scene, RectangleLight{{low, low, low}, {0, 0, e}, {e, 0, 0}, power});
    add_light(scene, RectangleLight{{low, high, low}, {e, 0, 0}, {0, 0, e}, power});
    return scene;
  };
  const auto seen = [&](const Material& material) {
    const PathScene scene = closed(material);
    return PathTracer(scene).estimate({9.5, 9.5, -15}, kAhead, 6000, 35)[0];
  };
  test.look(0.1);
  // Of collisions and light behind the fog together; lamps have no part of what the environment would give to escaped
  // paths.
  const PathScene fog = closed(isotropic(1));
  const auto all = PathTracer(fog).estimate({9.5, 9.5, -15}, kAhead, 6000, 35)[0];
  expect_near(all, 1, "fog");
  test.surface(0.4);
  expect_near(seen({.scattering = 1, .bsdf = Bsdf::kDiffuse}), 1, "diffuse");
  expect_near(seen({.scattering = 1, .bsdf = Bsdf::kDullReflection, .gloss = 0.8}), 1, "gloss");
  expect_near(seen({.scattering = 1, .bsdf = Bsdf::kSpecular}), 1, "mirror");
}

// A lamp in thin fog: light that was scattered once, by quadrature along the line of sight.
TEST(PointSource, GlowsInFogAsTheIntegralOfOnceScatteredLightSays) {
  UniformScene test({33, 33, 33});
  constexpr double kKappa = 0.05, kPower = 100;
  test.look(1 - std::exp(-kKappa));
  const Vec3 lamp{12, 21, 14};
  for (const float g : {0.0F, 0.7F}) {
    PathScene scene = path_scene(test, g == 0 ? isotropic(0.8) : forward(0.8, g));
    scene.scattering_colours[0] = {1, 0.5, 0.25};
    add_light(scene, PointLight{lamp, kPower}, {1, 1, 2});
    scene.max_scatterings = 1;
    double truth = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double s = 32.0 * (i + 0.5) / kSteps;
      const Vec3 way = Vec3{16, 16, s} - lamp;
      const double r = length(way), cosine = -dot(way, kAhead) / r;  // from the eye's direction to the lamp's
      const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2.0 * g * cosine, 1.5));
      truth += 32.0 / kSteps * 0.8 * kKappa * std::exp(-kKappa * (s + r)) * phase * kPower / (4 * kPi * r * r);
    }
    const auto found = PathTracer(scene).estimate({16, 16, -5}, kAhead, 30000, 36);
    expect_near(found[0], truth, "red");
    expect_near(found[1], 0.5 * truth, "green");
    expect_near(found[2], 0.5 * truth, "blue");
  }
}

// A wall at z = 8 that faces the eye.
class Wall : public TestScene {
 public:
  Wall() : TestScene({17, 17, 17}, [](Vec3 p) { return p.z / 16; }) { surface(0.5); }
  PathScene scene_of(const Material& material) const {
    PathScene out = path_scene(*this, material);
    out.max_extinction = 100;
    return out;
  }
};

TEST(Wall, ShowsItsIrradianceTimesItsAlbedo) {
  const Wall wall;
  PathScene scene = wall.scene_of({.scattering = 0.6, .bsdf = Bsdf::kDiffuse});
  add_light(scene, PointLight{{11, 8, 4}, 50}, {1, 0, 0});  // 5 away, cosine 4/5
  add_light(scene, SphereLight{{8, 5, 4}, 1, 50}, {0, 1, 0});
  add_light(scene, DirectionalLight{{3, 0, -4}, 2}, {0, 0, 1});
  const auto found = PathTracer(scene).estimate({8, 8, -9}, kAhead, 2000, 37);
  const double irradiance = 50 * 0.8 / (4 * kPi * 25);
  expect_near(found[0], 0.6 / kPi * irradiance, "point", 4e-3 * irradiance);  // the surface is 1/100 of a voxel soft
  expect_near(found[1], 0.6 / kPi * irradiance, "sphere", 4e-3 * irradiance);
  expect_near(found[2], 0.6 / kPi * 2 * 0.8, "distant");
}

TEST(Wall, OfAMirrorShowsTheLampInIt) {
  const Wall wall;
  PathScene scene = wall.scene_of({.scattering = 0.7, .bsdf = Bsdf::kSpecular});
  add_light(scene, RectangleLight{{10, 4, -5}, {8, 0, 0}, {0, 8, 0}, 5 * kPi * 64});  // radiance 5
  const auto found = PathTracer(scene).estimate({2, 8, -4}, {6, 0, 12}, 50, 38);
  EXPECT_NEAR(found[0].mean, 3.5, 1e-9);
  EXPECT_NEAR(found[0].error, 0, 1e-9);
  EXPECT_EQ(PathTracer(scene).estimate({2, 8, -4}, {0, 0, 12}, 50, 39)[0].mean, 0);
}

// A plate of glass reflects 2 R / (1 + R) with R of one face, since light is reflected within it any number of times.
TEST(Glass, OfAPlateReflectsWhatBothItsFacesDo) {
  TestScene test({9, 9, 33}, [](Vec3 p) { return std::clamp(std::min(p.z - 8, 24 - p.z) / 4, 0.0, 1.0); });
  test.scene.functions[0] = {{{0, {1, 1, 1}}}, {{0.4, 0}, {0.4, 1}, {0.6, 1}, {0.6, 0}}};
  PathScene scene = path_scene(test, {.scattering = 1, .bsdf = Bsdf::kTrap, .surface = true, .parameters = {1.5F}});
  scene.environment = [](Vec3 direction) { return Rgb{direction.z < 0 ? 1.0 : 0.0, direction.z > 0 ? 1.0 : 0.0, 0}; };
  const auto shares = PathTracer(scene).estimate({4, 4, -1}, kAhead, 40000, 40);
  expect_near(shares[0], 0.08 / 1.04, "reflected");
  expect_near(shares[1], 0.96 / 1.04, "transmitted");
}

// 120 estimates of a number that is known: three standard errors of 80 paths each hold the truth, and their squares'
// mean is 1.
TEST(PathTracer, SaysHowWrongItIs) {
  const SlabRow row = kSlabTable[4];
  Slab slab(row.optical_thickness, isotropic(row.albedo));
  double squares = 0, errors = 0, fewer = 0;
  constexpr int kEstimates = 120;
  for (std::uint64_t i = 0; i < kEstimates; ++i) {
    const Estimate found = slab.shares(320, 1000 + i)[0];
    squares += std::pow((found.mean - row.reflected) / found.error, 2);
    errors += found.error * found.error;
    const double error = slab.shares(80, 5000 + i)[0].error;
    fewer += error * error;
  }
  EXPECT_NEAR(squares / kEstimates, 1, 3 * std::sqrt(2.0 / kEstimates));
  EXPECT_NEAR(fewer / errors, 4, 0.2);  // the variance falls as 1 / n
}

TEST(RadiancePicture, DoesNotDependOnThreads) {
  TestScene test({17, 17, 17}, [](Vec3 p) { return 0.5 + 0.5 * std::sin(p.x + 2 * p.y * p.z); });
  test.scene.functions[0] = {{{0, {1, 1, 1}}}, {{0.2, 0}, {1, 0.4}}};
  test.scene.view.width = 7, test.scene.view.height = 5;
  PathScene scene = path_scene(test, isotropic(0.7));
  add_light(scene, PointLight{{30, 40, -10}, 100});
  const PathTracer tracer(scene);
  const RadiancePicture one = tracer.render(5, 41, 1), two = tracer.render(5, 41, 2), other = tracer.render(5, 42, 2);
  bool differs = false;
  for (std::size_t i = 0; i < one.pixels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(one.pixels[i][c].mean, two.pixels[i][c].mean);
      EXPECT_EQ(one.pixels[i][c].error, two.pixels[i][c].error);
      differs = differs || one.pixels[i][c].mean != other.pixels[i][c].mean;
    }
  }
  EXPECT_TRUE(differs);
}

TEST(PathTracer, RefusesWhatItCantTrace) {
  UniformScene test({4, 4, 4});
  PathScene scene = path_scene(test, isotropic(1));
  scene.lights.push_back(PointLight{});
  EXPECT_THROW(PathTracer{scene}, std::invalid_argument);
  scene.lights.clear();
  scene.materials[3] = {.bsdf = Bsdf::kTrap, .routine = 9};
  EXPECT_THROW(PathTracer{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace gicube::reference::paths
