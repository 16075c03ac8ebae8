// Light in volumes that the card does not store whole: its irradiance, its accounts and the pictures that it lights have the same bits
// as on a card that stores them whole.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "brick_scenes.h"
#include "gicube/testing.h"

namespace gicube::reference {
namespace {

Light make_light(std::mt19937& random, const Dims& dims) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const double most = std::max({dims[0], dims[1], dims[2]});
  const auto place = [&](std::size_t axis) { return dims[axis] / 2.0 + within(-0.8, 0.8) * most; };
  const Vec3 at{place(0), place(1), place(2)};
  switch (std::uniform_int_distribution(0, 3)(random)) {
    case 0: return PointLight{at, 1};
    case 1: return DirectionalLight{{within(-1, 1), within(-1, 1), 1.1}, 1 / most};
    case 2: return RectangleLight{at, {5, 1, 0}, {0, 1, 6}, 2};
    default: return SphereLight{at, 3, 1};
  }
}

Material make_material(std::mt19937& random) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  constexpr std::array kBsdfs{Bsdf::kNone,           Bsdf::kIsotropic, Bsdf::kDiffuse,
                              Bsdf::kDullScattering, Bsdf::kSpecular,  Bsdf::kTrap};
  Material out;
  out.bsdf = kBsdfs[std::uniform_int_distribution<std::size_t>(0, kBsdfs.size() - 1)(random)];
  out.scattering = out.bsdf == Bsdf::kNone ? 0 : within(0.2, 0.95);
  out.gloss = out.bsdf == Bsdf::kDullScattering ? 0.4 : 0;
  out.seen_through_scattering = std::bernoulli_distribution(0.6)(random);
  if (out.bsdf != Bsdf::kTrap) return out;
  const bool surface = std::bernoulli_distribution(0.5)(random);
  out.routine = surface ? kFresnelRoutine : kHenyeyGreensteinRoutine;
  out.surface = surface;
  out.parameters = {surface ? 1.4F : 0.6F};
  return out;
}

void expect_same_accounts(const LightingReport& got, const LightingReport& expected) {
  EXPECT_EQ(got.rays, expected.rays);
  EXPECT_EQ(got.emitted, expected.emitted);
  EXPECT_EQ(got.deposited, expected.deposited);
  EXPECT_EQ(got.escaped, expected.escaped);
  EXPECT_EQ(got.escaped_by_face, expected.escaped_by_face);
  EXPECT_EQ(got.scattered_away, expected.scattered_away);
  EXPECT_EQ(got.given_up, expected.given_up);
  EXPECT_EQ(got.clipped, expected.clipped);
  EXPECT_EQ(got.unit, expected.unit);
  EXPECT_EQ(got.warnings, expected.warnings);
  const auto units = [&](double energy) { return std::llround(energy / got.unit); };
  EXPECT_EQ(units(got.emitted),
            units(got.deposited) + units(got.escaped) + units(got.scattered_away) + units(got.clipped));
}

void expect_same_light(const std::string& base, const std::string& card, int scenes, int least, int most, int pixels,
                       unsigned seed) {
  std::mt19937 random(seed);
  BrickBoards boards(base, card);
  auto& [small, large] = boards;
  for (int scene = 0; scene < scenes; ++scene) {
    SCOPED_TRACE(base + ", scene " + std::to_string(scene));
    const Blobs blobs = make_blobs(random, least, most);
    const Material material = make_material(random);
    const double fog = scene % 3 == 0 ? 0 : 0.02;
    for (Board* board : boards.both()) {
      board->set_transfer_function(fog_and_balls(fog));
      board->set_material(material);
      board->load_volume(blobs.view());
    }
    std::vector<Light> lights{make_light(random, blobs.dims)};
    if (scene % 2 == 0) lights.push_back(make_light(random, blobs.dims));
    const auto flip = [&] { return std::bernoulli_distribution(0.5)(random); };
    Illumination settings;
    settings.albedo = flip() ? Albedo::kHigh : Albedo::kLow;
    settings.rules = flip() || flip() ? EnergyRules::kConserving : EnergyRules::kAsPrinted;
    settings.step = flip() ? 0.5 : 1.7;
    settings.jitter = flip();
    settings.leap = flip() || flip();
    settings.seed = static_cast<std::uint32_t>(scene);
    expect_same_accounts(small.illuminate(lights, settings), large.illuminate(lights, settings));
    ASSERT_EQ(small.read_irradiance(), large.read_irradiance());

    View view = make_view(random, blobs.dims, pixels);
    view.irradiance = true;
    ASSERT_EQ(small.render(view).pixels, large.render(view).pixels) << "lit";
    view.scatter = true;
    view.high_albedo = flip();
    view.irradiance = flip();
    ASSERT_EQ(small.render(view).pixels, large.render(view).pixels) << "scattered";

    std::vector<HostRay> rays;
    for (std::uint32_t i = 0; i < 50; ++i) {
      const auto at = [&](std::size_t axis) {
        return std::uniform_real_distribution(0.0, blobs.dims[axis] - 1.0)(random);
      };
      const Vec3 from{at(0), at(1), at(2)}, to{at(0), at(1), at(2)};
      rays.push_back({.id = i, .position = from, .direction = to - from, .energy = 3});
    }
    for (Board* board : boards.both()) board->clear_irradiance(1);
    const RayRequest deposits{.type = RayType::kDeposit, .albedo = settings.albedo, .rules = settings.rules};
    const RayBatch got = small.receive(small.submit(rays, deposits));
    const RayBatch expected = large.receive(large.submit(rays, deposits));
    expect_same_accounts(*got.lighting, *expected.lighting);
    ASSERT_EQ(small.read_irradiance(), large.read_irradiance());
    if (testing::Test::HasFailure()) return;
  }
  const Counters counters = small.counters();
  EXPECT_GT(counters.value("dsp.waits"), 0u);
  EXPECT_GT(counters.value("dsp.host_deposits"), 0u);
  EXPECT_GE(counters.value("dsp.block_loads"), counters.value("dsp.min_block_loads"));
  EXPECT_GT(counters.value("dsp.min_block_loads"), 0u);
  EXPECT_EQ(counters.value("pipeline.samples"), large.counters().value("pipeline.samples"));
  EXPECT_EQ(counters.value("pipeline.deposits"), large.counters().value("pipeline.deposits"));
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCard) {
  expect_same_light("emu:?set=asic.block_voxels=8", "32", 20, 36, 70, 24, 21);
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardOnOneThatStoresEightBlocks) {
  expect_same_light("emu:?set=asic.block_voxels=16", "32", 10, 36, 70, 24, 22);
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardOnTheWideDatapath) {
  expect_same_light("emu:?set=asic.block_voxels=8&set=asic.datapath=wide", "32", 8, 36, 70, 24, 23);
}

TEST(LightInBricks, HasTheBitsOfAnEndlessCardAtTheLevelsWithTime) {
  expect_same_light("emu:?fidelity=cycle&set=asic.block_voxels=8", "32", 2, 36, 56, 12, 48);
  expect_same_light("emu:?fidelity=approximate&set=asic.block_voxels=8&set=asic.datapath=wide", "32", 2, 36, 56, 12,
                    48);
}

}  // namespace
}  // namespace gicube::reference
