// Bit exactness of global illumination: the irradiance that lighting rays leave, its copies on block faces, the energy
// ledger, and pictures that are lit by it and see scattered rays, are those of the functional level on every machine.
#include "asic/sorter/policies.h"
#include "datapath/scattering.h"
#include "firmware/ray_sources/light_rays.h"
#include "lighting_rig.h"
#include "random_machine.h"
#include "seeds.h"
#include "test.h"

namespace gicube::emu {
namespace {

// A third of what comes is absorbed, the rest goes back or sideways.
class OneRoutine : public Routines {
 public:
  bool has(std::uint8_t number) const override { return number == 0; }
  std::optional<std::string> fault(std::uint8_t, std::span<const float>) const override { return std::nullopt; }
  ScatterAnswer scatter(std::uint8_t, const ScatterEvent& event) const override {
    ScatterAnswer answer;
    const std::array<double, 3>& d = event.direction;
    answer.direction = event.random[0] < 0.5 ? std::array{-d[0], -d[1], -d[2]} : std::array{d[1], d[2], d[0]};
    answer.passes = 2.0 / 3;
    answer.cycles = 50;
    return answer;
  }
};

void draw_materials(Frame& frame, Dice& dice) {
  for (wire::Material& material : frame.materials) {
    material.bsdf = static_cast<wire::Bsdf>(dice.number(0, 6));
    material.scattering = static_cast<std::uint16_t>(dice.one_of({0, 20'000, 50'000, 65'535}));
    material.gloss = static_cast<std::uint16_t>(dice.one_of({0, 1000, 9000}));
    material.flags = static_cast<std::uint8_t>(dice.number(0, 3));
  }
  for (std::size_t word = 0; word < kColours; ++word) {
    frame.light_colour[word] = static_cast<std::uint16_t>(dice.one_of({0, 700, 40'000, 65'535}));
    for (auto& colour : frame.scattering_colour) {
      colour[word] = static_cast<std::uint16_t>(dice.one_of({0, 9'000, 65'535}));
    }
  }
}

wire::IlluminateCommand draw_light(const Scene& scene, Dice& dice) {
  const auto& size = scene.volume.size();
  wire::IlluminateCommand command;
  command.kind = static_cast<wire::LightKind>(dice.number(0, 3));
  command.albedo = dice.chance(50) ? wire::Albedo::kHigh : wire::Albedo::kLow;
  command.rules = dice.chance(30) ? wire::EnergyRules::kAsPrinted : wire::EnergyRules::kConserving;
  command.rays_per_voxel = command.count = static_cast<std::uint32_t>(dice.number(1, 2));
  command.energy = dice.one_of({50.0, 4e4, 1e6});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    command.position[axis] = dice.number(-size[axis], 2 * size[axis]);
    command.u[axis] = dice.number(-20, 20) + 0.25;
  }
  command.v = {command.u[1], -command.u[0], 1};
  if (command.kind == wire::LightKind::kSphere) command.u[0] = 3;
  return command;
}

struct Irradiance {
  // With as many words as the scene's frame.
  Irradiance(const Scene& scene, bool wide) {
    for (std::size_t word = 0; word < scene.frame.light_words; ++word) {
      memory.emplace_back(scene.volume.block_voxels(),
                          wide ? IrradianceMemory::kWideMost : IrradianceMemory::kPaperMost);
      memory.back().resize(scene.volume.size());
    }
  }
  // Every word of every block, copies too; blocks that were not reached as zeros.
  std::vector<std::uint32_t> words(const Scene& scene) const {
    const auto edge = static_cast<std::size_t>(scene.volume.block_voxels()) + 1, count = edge * edge * edge;
    std::vector<std::uint32_t> all;
    for (const IrradianceMemory& each : memory) {
      for (std::size_t block = 0; block < scene.volume.block_count(); ++block) {
        const std::uint32_t* view = each.view(block);
        if (view == nullptr) {
          all.insert(all.end(), count, 0);
        } else {
          all.insert(all.end(), view, view + count);
        }
      }
    }
    return all;
  }

  std::vector<IrradianceMemory> memory;
};

// All copies of a voxel on the faces of blocks hold the same.
void expect_equal_copies(const Scene& scene, const IrradianceMemory& memory) {
  const int n = scene.volume.block_voxels();
  const auto edge = static_cast<std::size_t>(n) + 1;
  const auto& blocks = scene.volume.blocks();
  for (std::size_t block = 0; block < scene.volume.block_count(); ++block) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto nx = static_cast<std::size_t>(blocks[0]), ny = static_cast<std::size_t>(blocks[1]);
      const std::array<std::size_t, 3> at{block % nx, block / nx % ny, block / (nx * ny)};
      if (at[axis] + 1 == static_cast<std::size_t>(blocks[axis])) continue;
      const std::size_t next = block + std::array<std::size_t, 3>{1, nx, nx * ny}[axis];
      const std::array<std::size_t, 3> stride{1, edge, edge * edge};
      const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
      for (std::size_t i = 0; i < edge; ++i) {
        for (std::size_t j = 0; j < edge; ++j) {
          const std::size_t here = i * stride[b] + j * stride[c];
          const std::uint32_t *near = memory.view(block), *far = memory.view(next);
          const std::uint32_t copy = near != nullptr ? near[here + (edge - 1) * stride[axis]] : 0;
          ASSERT_EQ(copy, far != nullptr ? far[here] : 0) << "blocks " << block << " and " << next;
        }
      }
    }
  }
}

void expect_equal(const RayCounters& a, const RayCounters& b) {
  EXPECT_EQ(a.rays, b.rays);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.visible_samples, b.visible_samples);
  EXPECT_EQ(a.leaps, b.leaps);
  EXPECT_EQ(a.scatterings, b.scatterings);
  EXPECT_EQ(a.traps, b.traps);
  EXPECT_EQ(a.trap_cycles, b.trap_cycles);
  EXPECT_EQ(a.deposits, b.deposits);
  for (std::size_t word = 0; word < kColours; ++word) {
    const EnergyCounters &mine = a.energy_of(word), &its = b.energy_of(word);
    EXPECT_EQ(mine.deposited.kept, its.deposited.kept);
    EXPECT_EQ(mine.deposited.clipped, its.deposited.clipped);
    EXPECT_EQ(mine.escaped, its.escaped);
    EXPECT_EQ(mine.escaped_by_face, its.escaped_by_face);
    EXPECT_EQ(mine.scattered_away, its.scattered_away);
    EXPECT_EQ(mine.given_up, its.given_up);
  }
}

class RandomLight : public testing::TestWithParam<unsigned> {
 protected:
  RandomLight() : dice(GetParam()), n(dice.one_of({8, 8, 16})), wide(dice.chance(30)) {}

  Dice dice;
  int n;
  bool wide;
  OneRoutine routine;
};

TEST_P(RandomLight, LeavesTheSameIrradianceAndLedgerOnEveryMachineAndPicturesOfItAreTheSame) {
  const std::vector<std::string> assignments = draw_machine(dice, n);
  SCOPED_TRACE(text(assignments));
  const v1::BoardConfig config = config_with(assignments);
  Scene scene({dice.number(10, 40), dice.number(10, 40), dice.number(10, 40)}, n, format_of(config));
  draw(scene, dice);
  Frame& frame = scene.frame;
  draw_materials(frame, dice);
  frame.type = wire::RayType::kDeposit;
  frame.wide = wide;
  frame.light_words = config.asic().irradiance_words();
  frame.routines = &routine;
  frame.seed = GetParam();
  const std::uint32_t threshold = std::exchange(frame.opacity_threshold, wire::kOpacityOne);
  frame.lifetime = static_cast<std::uint16_t>(dice.one_of({0, 3, 40}));
  const wire::IlluminateCommand light = draw_light(scene, dice);
  frame.rules = light.rules;
  scene.set_depths();
  const unsigned bits = wide ? 24 : light.albedo == wire::Albedo::kHigh ? 4 : 8;
  const LightingRays maker(light, frame.extent, frame.spacing, bits, frame.seed);
  LightRays rays(maker, frame);

  Irradiance expected(scene, wide), held(scene, wide), shuffled_held(scene, wide);
  Progress work;
  frame.irradiance = expected.memory.data();
  const RayCounters counts = run_functional(rays, frame, 2).rays;
  frame.irradiance = held.memory.data();
  Machine machine(config, scene.volume.blocks());
  const RunResult ran = machine.run(rays, frame, work);
  EXPECT_EQ(held.words(scene), expected.words(scene));
  for (const IrradianceMemory& memory : held.memory) expect_equal_copies(scene, memory);
  expect_equal(ray_counters(machine), counts);
  for (std::size_t word = 0; word < frame.light_words; ++word) {
    const EnergyCounters& energy = counts.energy_of(word);
    EXPECT_EQ(ran.rays.energy_of(word).emitted, energy.emitted);
    EXPECT_EQ(energy.emitted,
              energy.deposited.kept + energy.deposited.clipped + energy.escaped + energy.scattered_away);
    EXPECT_EQ(std::accumulate(energy.escaped_by_face.begin(), energy.escaped_by_face.end(), std::uint64_t{0}),
              energy.escaped);
  }

  std::uint64_t tiles = 0, fetched = 0, packets = 0, written = 0, read = 0;
  for (const auto& processor : machine.processors()) {
    const CauseCounts& causes = processor->causes();
    EXPECT_EQ(std::accumulate(causes.begin(), causes.end(), std::uint64_t{0}), machine.now());
    EXPECT_TRUE(processor->idle());
    const WriteCounters& writes = processor->writes().counters();
    tiles += writes.tiles - writes.combined;
    fetched += writes.fetches;
    packets += processor->cache().counters().packets;
  }
  for (const auto& memory : machine.memories()) {
    written += memory->channel().counters().packets_written;
    read += memory->channel().counters().packets_read;
  }
  EXPECT_EQ(written, tiles * (frame.light_words == 3 ? 2 : 1));  // each changed tile has gone to the memory
  EXPECT_EQ(read, (fetched + (config.ideal().memory() != 0 ? 0 : packets)) * packets_of_tile(config));

  frame.irradiance = shuffled_held.memory.data();
  Machine shuffled(config, scene.volume.blocks());
  shuffled.shuffle_ticks(GetParam() + 1);
  EXPECT_EQ(shuffled.run(rays, frame, work).cycles, ran.cycles);
  EXPECT_EQ(shuffled_held.words(scene), expected.words(scene));
  EXPECT_THAT(counter_texts(shuffled), testing::ElementsAreArray(counter_texts(machine)));

  frame.type = wire::RayType::kIntegrate;
  frame.rules = wire::EnergyRules::kConserving;
  frame.lit_by_irradiance = dice.chance(80);
  frame.scatter = dice.chance(80);
  frame.high_albedo = dice.chance(30);
  frame.exposure = 3000;
  frame.opacity_threshold = threshold;
  if (wide) scene.widen();
  const wire::RenderCommand view = draw_view(scene, dice);
  const RayCounters before = ray_counters(machine);
  const RunRules runs = runs_of(config);
  const std::vector<wire::Lamp> records = draw_lamps(scene, dice);
  const Lamps lamps(records, frame.spacing);
  const Picture dark = functional_picture(scene, view, runs);
  frame.lamps = !lamps.empty();
  const Picture picture = cycle_picture(scene, view, machine, runs, lamps),
                functional = functional_picture(scene, view, runs, lamps);
  EXPECT_EQ(picture.pixels, functional.pixels);
  if (records.empty() || !frame.scatter) {
    EXPECT_EQ(functional.pixels, dark.pixels);
  }
  expect_equal(functional.rays, dark.rays);
  expect_equal(ray_counters(machine) - before, functional.rays);

  // Values of lit rays that are known before their time change no cycle.
  if (!frame.gathers() || frame.lamps || reads_contribution(config.sorter().policy())) return;
  Machine each(config, scene.volume.blocks()), ahead(config, scene.volume.blocks());
  const Picture one_by_one = cycle_picture(scene, view, each, runs),
                known = ahead_picture(scene, view, ahead, runs, false);
  EXPECT_EQ(known.pixels, one_by_one.pixels);
  EXPECT_EQ(known.ran.cycles, one_by_one.ran.cycles);
  EXPECT_THAT(counter_texts(ahead), testing::ElementsAreArray(counter_texts(each)));
}

INSTANTIATE_TEST_SUITE_P(Scenes, RandomLight, seeds(200));

}  // namespace
}  // namespace gicube::emu
