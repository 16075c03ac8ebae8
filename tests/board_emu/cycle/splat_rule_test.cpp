// Which samples of a lighting ray write their eight voxels, and when those go to memory: traffic and time alone depend
// on it.
#include "lighting_rig.h"
#include "test.h"
#include "voxels.h"

namespace gicube::emu {
namespace {

struct Pass {
  RayCounters rays;
  std::uint64_t deposits = 0, carriers = 0;
  WriteCounters tiles{};
  std::uint64_t written = 0;  // packets, to the memories
  Cycle cycles = 0;
  std::vector<std::uint32_t> irradiance;
};

// Light from above through a box of which one half, in x, is fog.
Pass light(const char* rule, int block_voxels, const char* policy = "combining", const char* ways = "1",
           const char* packing = "with_voxels") {
  LitScene lit({16, 16, 16}, block_voxels, false);
  lit.scene.fill([](int x, int, int) { return wire::Voxel{0, 0, static_cast<std::uint8_t>(x < 8 ? 1 : 0), 0}; });
  lit.medium(0.05, 0, wire::Bsdf::kNone, 1);
  const wire::IlluminateCommand command = light_of(wire::LightKind::kPoint, 40'000, {7, 40, 8}, 1);
  lit.scene.frame.rules = command.rules;
  lit.scene.set_depths();
  const LightingRays maker = lit.rays(command);
  const v1::BoardConfig config =
      config_with({std::string("cache.splat_rule=") + rule, std::string("cache.write_policy=") + policy,
                   std::string("cache.ways=") + ways, std::string("cache.irradiance=") + packing, "asic.processors=2",
                   "asic.partition=skewed_block", "asic.block_voxels=" + std::to_string(block_voxels)});
  LightRays rays(maker, lit.scene.frame);
  Machine machine(config, lit.scene.volume.blocks());
  Progress work;
  Pass pass;
  pass.cycles = machine.run(rays, lit.scene.frame, work).cycles;
  pass.rays = ray_counters(machine);
  for (const auto& processor : machine.processors()) {
    pass.deposits += processor->splats().counters().deposits;
    pass.carriers += processor->splats().counters().carriers;
    pass.tiles.tiles += processor->writes().counters().tiles;
    pass.tiles.combined += processor->writes().counters().combined;
    pass.tiles.fetches += processor->writes().counters().fetches;
  }
  for (const auto& memory : machine.memories()) pass.written += memory->channel().counters().packets_written;
  for_each_voxel({16, 16, 16}, [&](int x, int y, int z) { pass.irradiance.push_back(lit.irradiance_at(x, y, z)); });
  return pass;
}

TEST(SplatRule, DecidesWhichSamplesWriteInABlockThatHasNoNeighbours) {
  const Pass units = light("whole_units", 16), visible = light("visible_samples", 16), all = light("all_samples", 16);
  EXPECT_EQ(units.deposits, units.rays.deposits);
  // An invisible sample deposits too if a visible medium begins within its part.
  EXPECT_GE(visible.deposits, visible.rays.visible_samples);
  EXPECT_LE(visible.deposits, visible.rays.visible_samples + visible.rays.visible_samples / 100);
  EXPECT_EQ(all.deposits, all.rays.samples);
  EXPECT_LT(units.deposits, visible.deposits);
  EXPECT_LT(visible.deposits, all.deposits);
  // A tile is 2 x 2 x 1 voxels: eight lie in two tiles at least and in eight at most.
  for (const Pass* pass : {&visible, &all}) {
    EXPECT_GT(pass->tiles.tiles, 2 * pass->deposits);
    EXPECT_LT(pass->tiles.tiles, 8 * pass->deposits);
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

TEST(WritePolicy, ChangesNoIrradianceAndNoLedgerAndWritesEachTileThatHasChanged) {
  for (const int block_voxels : {8, 16}) {
    for (const char* ways : {"1", "2"}) {
      SCOPED_TRACE(ways);
      const Pass combining = light("all_samples", block_voxels, "combining", ways),
                 through = light("all_samples", block_voxels, "write_through", ways),
                 back = light("all_samples", block_voxels, "write_back", ways);
      for (const Pass* pass : {&through, &back}) {
        EXPECT_EQ(pass->irradiance, combining.irradiance);
        EXPECT_EQ(pass->rays.energy.deposited.kept, combining.rays.energy.deposited.kept);
        EXPECT_EQ(pass->written, pass->tiles.tiles - pass->tiles.combined);
      }
      EXPECT_EQ(through.tiles.combined, 0u);
      EXPECT_LT(combining.written, through.written);
      EXPECT_LT(back.written, combining.written);
    }
  }
}

// Nothing takes the place of a tile of the one block, so each is written once, at the end.
TEST(WritePolicy, BackWritesEachTileOfAVolumeThatFitsTheCacheOnce) {
  const Pass back = light("all_samples", 16, "write_back");
  EXPECT_GT(back.tiles.tiles, 10'000u);
  EXPECT_LE(back.written, 9u * 9 * 17);
  EXPECT_GT(back.written, 8u * 8 * 16 * 9 / 10);
}

TEST(IrradiancePacking, ChangesNoIrradianceAndNoLedgerUnderAnyRuleAndPolicy) {
  for (const char* rule : {"whole_units", "all_samples"}) {
    const Pass voxels = light(rule, 8);
    for (const char* policy : {"combining", "write_through", "write_back"}) {
      SCOPED_TRACE(policy);
      const Pass cells = light(rule, 8, policy, "2", "in_cells");
      EXPECT_EQ(cells.irradiance, voxels.irradiance);
      EXPECT_EQ(cells.rays.energy.deposited.kept, voxels.rays.energy.deposited.kept);
      EXPECT_EQ(cells.rays.energy.escaped, voxels.rays.energy.escaped);
      EXPECT_EQ(cells.written, cells.tiles.tiles - cells.tiles.combined);
    }
  }
}

// Of 2 x 2 x 2 voxels at any place (3/2)^3 = 3.4 cells have some in the mean, and (3/2)^2 * 2 = 4.5 tiles.
TEST(IrradiancePacking, OfCellsWritesThreeQuartersOfThePacketsOfTiles) {
  const Pass tiles = light("all_samples", 16, "write_through"),
             cells = light("all_samples", 16, "write_through", "1", "in_cells");
  EXPECT_EQ(cells.deposits, tiles.deposits);
  EXPECT_NEAR(static_cast<double>(cells.written) / static_cast<double>(tiles.written), 0.75, 0.05);
}

}  // namespace
}  // namespace gicube::emu
