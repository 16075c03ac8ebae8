// Which samples of a lighting ray write their eight voxels: traffic and time alone depend on it.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lighting_rig.h"

namespace gicube::emu {
namespace {

struct Pass {
  RayCounters rays;
  std::uint64_t deposits = 0, carriers = 0, tiles = 0;
  Cycle cycles = 0;
  std::vector<std::uint32_t> irradiance;
};

// Light from above through a box of which one half, in x, is fog.
Pass light(const char* rule, int block_voxels) {
  LitScene lit({16, 16, 16}, block_voxels, false);
  lit.scene.fill([](int x, int, int) { return wire::Voxel{0, 0, static_cast<std::uint8_t>(x < 8 ? 1 : 0), 0}; });
  lit.medium(0.05, 0, wire::Bsdf::kNone, 1);
  const wire::IlluminateCommand command = light_of(wire::LightKind::kPoint, 40'000, {7, 40, 8}, 1);
  lit.scene.frame.rules = command.rules;
  lit.scene.set_depths();
  const LightingRays maker = lit.rays(command);
  const v1::BoardConfig config =
      config_with({std::string("cache.splat_rule=") + rule, "asic.processors=2", "asic.partition=skewed_block",
                   "asic.block_voxels=" + std::to_string(block_voxels)});
  LightRays rays(maker, lit.scene.frame, config.dsp());
  Machine machine(config, lit.scene.volume.blocks());
  Progress work;
  Pass pass;
  pass.cycles = machine.run(rays, lit.scene.frame, work).cycles;
  pass.rays = ray_counters(machine);
  for (const auto& processor : machine.processors()) {
    pass.deposits += processor->splats().counters().deposits;
    pass.carriers += processor->splats().counters().carriers;
    pass.tiles += processor->writes().counters().tiles;
  }
  for (int z = 0; z < 16; ++z) {
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) pass.irradiance.push_back(lit.irradiance_at(x, y, z));
    }
  }
  return pass;
}

TEST(SplatRule, DecidesWhichSamplesWriteInABlockThatHasNoNeighbours) {
  const Pass units = light("whole_units", 16), visible = light("visible_samples", 16), all = light("all_samples", 16);
  EXPECT_EQ(units.deposits, units.rays.deposits);
  EXPECT_EQ(visible.deposits, visible.rays.visible_samples);
  EXPECT_EQ(all.deposits, all.rays.samples);
  EXPECT_LT(units.deposits, visible.deposits);
  EXPECT_LT(visible.deposits, all.deposits);
  // A tile is 2 x 2 x 1 voxels: eight lie in two tiles at least and in eight at most.
  for (const Pass* pass : {&visible, &all}) {
    EXPECT_GT(pass->tiles, 2 * pass->deposits);
    EXPECT_LT(pass->tiles, 8 * pass->deposits);
  }
}

TEST(SplatRule, ChangesNoIrradianceAndNoLedgerButTakesTime) {
  for (const int block_voxels : {8, 16}) {
    const Pass units = light("whole_units", block_voxels);
    Cycle least = units.cycles;
    for (const char* rule : {"visible_samples", "all_samples"}) {
      SCOPED_TRACE(rule);
      const Pass pass = light(rule, block_voxels);
      EXPECT_EQ(pass.irradiance, units.irradiance);
      EXPECT_EQ(pass.rays.samples, units.rays.samples);
      EXPECT_EQ(pass.rays.energy.deposited.kept, units.rays.energy.deposited.kept);
      EXPECT_EQ(pass.rays.energy.escaped, units.rays.energy.escaped);
      EXPECT_GT(pass.cycles, least);
      least = pass.cycles;
    }
  }
}

TEST(SplatRule, SendsEveryWriteToTheNeighboursThatHaveCopies) {
  const Pass units = light("whole_units", 8), all = light("all_samples", 8);
  // What a carrier brings is counted too, in the block where it arrives.
  EXPECT_GT(all.carriers, units.carriers);
  EXPECT_GE(all.deposits, all.rays.samples);
  EXPECT_LE(all.deposits, all.rays.samples + all.carriers);
}

}  // namespace
}  // namespace gicube::emu
