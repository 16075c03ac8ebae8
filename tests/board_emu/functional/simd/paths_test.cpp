// Lighting rays and scattered rays side by side in vectors give the bits of the plain way: rays, irradiance and
// ledgers, on every instruction set that this host has.
#include "datapath/scattering.h"
#include "functional/functional.h"
#include "functional/simd/simd_tracer.h"
#include "instruction_sets.h"
#include "random_machine.h"
#include "seeds.h"
#include "test.h"

namespace gicube::emu {
namespace {

// A third of what comes is absorbed, the rest goes back or sideways.
class MirrorRoutine : public Routines {
 public:
  bool has(std::uint8_t number) const override { return number == 0; }
  std::optional<std::string> fault(std::uint8_t, std::span<const float>) const override { return std::nullopt; }
  ScatterAnswer scatter(std::uint8_t, const ScatterEvent& event) const override {
    const std::array<double, 3>& d = event.direction;
    ScatterAnswer answer;
    answer.direction = event.random[0] < 0.5 ? std::array{-d[0], -d[1], -d[2]} : std::array{d[1], d[2], d[0]};
    answer.passes = 2.0 / 3;
    answer.cycles = 50;
    return answer;
  }
};

struct TracedRays {
  std::vector<wire::Ray> rays;
  RayCounters counters;
  std::vector<bool> ended;
  std::vector<std::uint32_t> irradiance;
};

TracedRays trace_rays(const Scene& scene, std::vector<wire::Ray> rays, const SimdTracer* tracer) {
  TracedRays out{std::move(rays), {}, {}, {}};
  Frame frame = scene.frame;
  std::vector<IrradianceMemory> irradiance;
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    irradiance.emplace_back(scene.volume.block_voxels(),
                            frame.wide ? IrradianceMemory::kWideMost : IrradianceMemory::kPaperMost);
    irradiance.back().resize(scene.volume.size());
  }
  if (frame.lights()) frame.irradiance = irradiance.data();
  out.ended = integrate_all(out.rays, frame, out.counters, tracer);
  const auto edge = static_cast<std::size_t>(scene.volume.block_voxels()) + 1;
  for (const IrradianceMemory& memory : irradiance) {
    for (std::size_t block = 0; block < scene.volume.block_count(); ++block) {
      const std::uint32_t* const words = memory.view(block);
      if (words != nullptr) out.irradiance.insert(out.irradiance.end(), words, words + edge * edge * edge);
      out.irradiance.push_back(words != nullptr);
    }
  }
  return out;
}

std::vector<std::uint64_t> numbers(const RayCounters& counters) {
  const EnergyCounters& energy = counters.energy;
  std::vector<std::uint64_t> out{counters.rays,
                                 counters.samples,
                                 counters.visible_samples,
                                 counters.leaps,
                                 counters.terminated,
                                 counters.lighting_rays,
                                 counters.scatterings,
                                 counters.traps,
                                 counters.trap_cycles,
                                 counters.deposits,
                                 energy.emitted,
                                 energy.deposited.kept,
                                 energy.deposited.clipped,
                                 energy.escaped,
                                 energy.scattered_away,
                                 energy.given_up};
  out.insert(out.end(), energy.escaped_by_face.begin(), energy.escaped_by_face.end());
  for (const EnergyCounters& more : counters.more_energy) {
    out.insert(out.end(),
               {more.deposited.kept, more.deposited.clipped, more.escaped, more.scattered_away, more.given_up});
  }
  return out;
}

void expect_equal(const TracedRays& got, const TracedRays& expected) {
  EXPECT_EQ(numbers(got.counters), numbers(expected.counters));
  EXPECT_EQ(got.ended, expected.ended);
  EXPECT_EQ(got.irradiance, expected.irradiance);
  for (std::size_t i = 0; i < expected.rays.size(); ++i) ASSERT_EQ(got.rays[i], expected.rays[i]) << "ray " << i;
}

// Balls, or a fog of changing density all over; in some of its voxels it is opaque, or clear.
void draw_media(Scene& scene, Dice& dice) {
  draw(scene, dice);
  if (dice.chance(60)) {
    const int base = dice.number(0, 3000), contrast = dice.one_of({0, 0, 3, 40, 900});
    const bool tagged = dice.chance(40);
    scene.fill([&](int x, int y, int z) {
      wire::Voxel voxel;
      voxel.density = static_cast<std::uint16_t>(base + (x * 37 + y * 101 + z * 57) % (contrast + 1));
      voxel.tag = static_cast<std::uint8_t>(tagged ? (x / 5 + y / 4) & 3 : 0);
      voxel.gradient = static_cast<std::uint16_t>((x * 7 + y * 131 + z * 31) % 2048);
      return voxel;
    });
    const int thin = dice.one_of({20, 300, 4000, 40'000}), gaps = dice.one_of({0, 0, 3}),
              walls = dice.one_of({0, 0, 40});
    for (std::size_t i = 0; i < scene.segmentation.size(); ++i) {
      auto& opacity = scene.segmentation[i].opacity;
      opacity = static_cast<std::uint16_t>(thin + static_cast<int>(i % 4096) / 2);
      if (gaps != 0 && i / 8 % static_cast<unsigned>(gaps) == 0) opacity = 0;
      if (walls != 0 && static_cast<int>(i % 4096) % walls == 0) opacity = wire::kClassifiedOpacityOne;
    }
  }
  for (wire::Material& material : scene.frame.materials) {
    material.bsdf = static_cast<wire::Bsdf>(dice.number(0, 6));
    material.scattering = static_cast<std::uint16_t>(dice.one_of({0, 20'000, 50'000, 65'535}));
    material.gloss = static_cast<std::uint16_t>(dice.one_of({0, 1000, 9000}));
    material.flags = static_cast<std::uint8_t>(dice.number(0, 3));
  }
}

void draw_frame(Scene& scene, Dice& dice, const Routines& routine) {
  Frame& frame = scene.frame;
  frame.routines = &routine;
  frame.seed = static_cast<std::uint32_t>(dice.number(0, 1 << 30));
  frame.lifetime = static_cast<std::uint16_t>(dice.one_of({0, 3, 40}));
  frame.step = static_cast<std::uint32_t>(dice.one_of({9'000, 32'768, 65'536, 150'000}));
  frame.jitter = false;
  frame.type = wire::RayType::kIntegrate;
  if (dice.chance(40)) scene.widen();
  if (dice.chance(60)) {
    frame.type = wire::RayType::kDeposit;
    frame.opacity_threshold = wire::kOpacityOne;
    frame.rules = dice.chance(30) ? wire::EnergyRules::kAsPrinted : wire::EnergyRules::kConserving;
    frame.light_words = dice.chance(40) ? 3 : 1;
    for (std::size_t word = 0; word < kColours; ++word) {
      frame.light_colour[word] = static_cast<std::uint16_t>(dice.one_of({0, 700, 40'000, 65'535}));
      for (auto& colour : frame.scattering_colour) {
        colour[word] = static_cast<std::uint16_t>(dice.one_of({0, 9'000, 65'535}));
      }
    }
  } else {
    frame.scatter = dice.chance(80);
    frame.high_albedo = !frame.scatter || dice.chance(30);
    frame.lit_by_irradiance = dice.chance(50);
    frame.light_words = dice.chance(30) ? 3 : 1;
    frame.exposure = static_cast<std::uint32_t>(dice.one_of({4'000, 65'536, 900'000}));
  }
  scene.set_depths();
}

// Light in some voxels, for frames that are lit by it; more than a word of the interpolator has in some of them.
void draw_light(Scene& scene, IrradianceMemory& light, Dice& dice) {
  light.resize(scene.volume.size());
  for (int i = dice.number(0, 200); i > 0; --i) {
    Deposit deposit;
    for (std::size_t axis = 0; axis < 3; ++axis) deposit.voxel[axis] = dice.number(0, scene.volume.size()[axis] - 2);
    for (std::uint32_t& share : deposit.shares) {
      share = static_cast<std::uint32_t>(dice.number(0, 500)) << (scene.frame.wide ? dice.number(0, 22) : 0);
    }
    light.add(deposit);
  }
  light.expect_deposits();
}

// Some of another kind than the most, some that have been scattered or trapped before.
std::vector<wire::Ray> draw_path_rays(const Scene& scene, Dice& dice) {
  std::vector<wire::Ray> rays = draw_rays(scene, dice);
  const bool high = dice.chance(50);
  for (wire::Ray& ray : rays) {
    ray.lifetime = scene.frame.lifetime;
    if (!scene.frame.lights()) continue;
    ray.flags = wire::kLightingRay;
    if (high != dice.chance(5)) ray.flags |= wire::kHighAlbedo;
    ray.opacity = 0;
    ray.generation = static_cast<std::uint8_t>(dice.chance(10) ? dice.number(1, 15) : 0);
    if (dice.chance(5)) ray.flags |= wire::kTrapped;
    const int energy = dice.one_of({1, 15, 255, scene.frame.wide ? 1 << 23 : 255});
    ray.set_colour_word(static_cast<std::uint64_t>(energy) << kEnergyFractionBits |
                        static_cast<std::uint64_t>(dice.chance(20) ? dice.number(0, 4095) : 0));
  }
  return rays;
}

class PathsOfRandomScenes : public testing::TestWithParam<unsigned> {};

TEST_P(PathsOfRandomScenes, GiveTheBitsOfThePlainWay) {
  Dice dice(GetParam());
  const MirrorRoutine routine;
  const int n = dice.one_of({8, 16, 32});
  const wire::VoxelFormat format =
      dice.one_of({wire::VoxelFormat::kDensity, wire::VoxelFormat::kRgb, wire::VoxelFormat::kRgba});
  Scene scene({dice.number(10, 40), dice.number(10, 40), dice.number(10, 40)}, n, format);
  draw_media(scene, dice);
  draw_frame(scene, dice, routine);
  std::vector<IrradianceMemory> light;
  for (std::size_t word = 0; word < scene.frame.light_words; ++word) {
    light.emplace_back(scene.volume.block_voxels(), IrradianceMemory::kWideMost);
    draw_light(scene, light.back(), dice);
  }
  scene.frame.irradiance = light.data();
  SimdTracer tracer(scene.opacity_correction);
  ASSERT_TRUE(tracer.prepare(1 << 20, scene.frame, 0, 2));
  std::vector<wire::Ray> rays = draw_path_rays(scene, dice);
  if (dice.chance(30)) rays.resize(std::min<std::size_t>(rays.size(), static_cast<std::size_t>(dice.number(1, 17))));
  const TracedRays expected = trace_rays(scene, rays, nullptr);
  on_every_target([&] { expect_equal(trace_rays(scene, rays, &tracer), expected); });
}

INSTANTIATE_TEST_SUITE_P(Scenes, PathsOfRandomScenes, seeds(400));

}  // namespace
}  // namespace gicube::emu
