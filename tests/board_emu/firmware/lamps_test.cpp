// The lamps that scattered rays see: what is refused of their records, and what looking for them costs.
#include "firmware/lamps.h"

#include "commands_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

wire::Lamp sphere_lamp(const std::array<double, 3>& at, double radius) {
  return {.kind = wire::LightKind::kSphere, .colour = {65536, 32768, 0}, .position = at, .u = {radius, 0, 0}};
}

std::vector<std::uint8_t> with_lamps(const std::vector<wire::Lamp>& lamps) {
  wire::RenderCommand view = corner_view({17, 17, 17}, 8);
  view.lamps = static_cast<std::uint8_t>(lamps.size());
  std::vector<std::uint8_t> payload = wire::encoded(view);
  for (const wire::Lamp& lamp : lamps) wire::append(payload, lamp);
  return payload;
}

TEST(LampRecords, AreRefusedByTheFieldThatIsWrong) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  const wire::Lamp good = sphere_lamp({30, 8, 8}, 2);
  const wire::Lamp square{.position = {30, 0, 0}, .u = {0, 10, 0}, .v = {0, 0, 10}};
  const auto refused = [&](const auto& spoil) {
    wire::Lamp lamp = square;
    spoil(lamp);
    return refusal(board, with_lamps({good, lamp}));
  };
  EXPECT_EQ(refused([](wire::Lamp&) {}), "accepted");
  EXPECT_EQ(refused([](wire::Lamp& lamp) { lamp.kind = wire::LightKind::kDirectional; }),
            "lamp 1: kind: expected 2 (rectangle) or 3 (sphere), got 1");
  EXPECT_EQ(refused([](wire::Lamp& lamp) { lamp.kind = static_cast<wire::LightKind>(4); }),
            "lamp 1: kind: expected 2 (rectangle) or 3 (sphere), got 4");
  EXPECT_EQ(refused([](wire::Lamp& lamp) {
              lamp.v = {0, 5, 0};
            }),
            "lamp 1: u, v: expected edges of a rectangle, got parallel vectors");
  EXPECT_EQ(refused([](wire::Lamp& lamp) { lamp.position[1] = std::numeric_limits<double>::quiet_NaN(); }),
            "lamp 1: position: expected finite numbers of -1e9 to 1e9");
  EXPECT_EQ(refusal(board, with_lamps({sphere_lamp({30, 8, 8}, -1)})),
            "lamp 0: u.x: expected a sphere's radius of 1e-6 to 1e9, got -1.000000");
  EXPECT_EQ(refusal(board, with_lamps(std::vector(32, good))), "accepted");
  EXPECT_EQ(refusal(board, with_lamps(std::vector(33, good))), "lamps: expected 0..32, got 33");
  std::vector<std::uint8_t> cut = with_lamps({good, square});
  cut.pop_back();
  EXPECT_EQ(refusal(board, cut), "payload: expected 112 + 88 bytes for each of its 2 lamps, got 287");
  std::vector<std::uint8_t> more = with_lamps({});
  more.push_back(0);
  EXPECT_EQ(refusal(board, more), "payload: expected 112 + 88 bytes for each of its 0 lamps, got 113");
}

// A ray that left at (16, 8, 8) along x.
wire::Ray scattered_ray() {
  wire::Ray ray = host_ray(0, {16, 8, 8}, {1, 0, 0});
  ray.generation = 1;
  return ray;
}

constexpr std::array<std::uint32_t, 3> kCubes{wire::kSpacingOne, wire::kSpacingOne, wire::kSpacingOne};

TEST(Lamps, AddTheirLightTimesWhatTheRayLetsThrough) {
  const std::vector<wire::Lamp> records{sphere_lamp({30, 8, 8}, 2)};
  const emu::Lamps lamps(records, kCubes);
  wire::Ray ray = scattered_ray();
  EXPECT_EQ(lamps.seen_by(ray).colour, (std::array<std::uint16_t, 3>{4095, 2048, 0}));
  EXPECT_EQ(lamps.seen_by(ray).opacity, wire::kOpacityOne);
  ray.opacity = 3 * (wire::kOpacityOne / 4);
  ray.colour = {100, 100, 100};
  EXPECT_EQ(lamps.seen_by(ray).colour, (std::array<std::uint16_t, 3>{100 + 1024, 100 + 512, 100}));
  ray.colour = {4000, 0, 0};
  EXPECT_EQ(lamps.seen_by(ray).colour[0], 4095);
}

TEST(Lamps, AreSeenByRaysAloneThatWereScatteredAndLeft) {
  const std::vector<wire::Lamp> records{sphere_lamp({30, 8, 8}, 2)};
  const emu::Lamps lamps(records, kCubes);
  const wire::Ray ray = scattered_ray();
  wire::Ray primary = ray, ended = ray, away = ray;
  primary.generation = 0;
  ended.contribution = 0;
  away.direction = {-16384, 0, 0};
  for (const wire::Ray& each : {primary, ended, away}) EXPECT_EQ(lamps.seen_by(each), each);
  EXPECT_EQ(lamps.task(primary).loop, nullptr);
  EXPECT_EQ(lamps.task(ended).loop, nullptr);
  EXPECT_EQ(emu::Lamps().task(ray).loop, nullptr);
  EXPECT_EQ(lamps.task(away).loop, &kTestLamp);
}

// 36 multiplications by two units are 18 cycles; what the ray needs before, 20 operations and 7 accesses, 5.
TEST(Lamps, CostADspEachTheirTestAndTheRayItsOwnWords) {
  EXPECT_EQ(kTestLamp.interval(), 18u);
  EXPECT_EQ(kLookForLamps.interval(), 5u);
  for (const std::size_t count : {1, 32}) {
    const std::vector<wire::Lamp> records(count, sphere_lamp({30, 8, 8}, 2));
    const DspTask task = emu::Lamps(records, kCubes).task(scattered_ray());
    EXPECT_EQ(task.cycles(), 5 + 18 * count);
    ASSERT_EQ(task.use_count, 1);
    EXPECT_EQ(task.uses[0].bytes, 64 * count);
    EXPECT_EQ(task.uses[0].kind, SdramUse::Kind::kRead);
  }
}

// Each lamp more costs each ray that looks 18 cycles of 5 ns, the first one 5 more; beginning with the loop takes 24.
TEST(Lamps, CostAFrameTheirTestsAlone) {
  const auto busy = [](std::size_t lamps) {
    BareBoard board(blocks_of_eight());
    load_fog(board, 20'000);
    const wire::Material material{
        .bsdf = wire::Bsdf::kIsotropic, .flags = wire::kScattersRenderingRays, .scattering = wire::kScatteringOne};
    board.write_memory(wire::kMaterials.base, wire::encoded(material));
    board.write_register(wire::reg::kPipeline, wire::kPipelineScatter);
    carry_out(board, with_lamps(std::vector(lamps, sphere_lamp({30, 8, 8}, 2))));
    EXPECT_GT(board.counter("pipeline.scatterings"), 10u);
    return board.counter("dsp.busy_ps");
  };
  constexpr std::uint64_t kCycle = 5000;  // ps
  const std::uint64_t none = busy(0), one = busy(1), two = busy(2);
  EXPECT_GT(two, one);
  EXPECT_EQ((one - none - 24 * kCycle) * 18, (two - one) * 23);
}

// Rays that scatter nowhere cost what they cost without lamps.
TEST(Lamps, CostNothingWhereNoRayIsScattered) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    const auto time = [level](const std::vector<wire::Lamp>& lamps) {
      BareBoard board(blocks_of_eight(level));
      load_fog(board, 1000);
      carry_out(board, with_lamps(lamps));
      return board.counter("dsp.busy_ps");
    };
    EXPECT_EQ(time({}), time({sphere_lamp({30, 8, 8}, 2)}));
  }
}

}  // namespace
}  // namespace gicube::emu
