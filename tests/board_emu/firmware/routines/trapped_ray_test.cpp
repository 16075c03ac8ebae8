// Rays that trap on the DSP, through whole commands: what is wrong with a routine ends its command and nothing else,
// and no energy is lost.
#include "bare_board.h"
#include "config/config.h"
#include "fickle_bsdf.h"
#include "firmware/routines/routine_table.h"
#include "sanitizers.h"
#include "test.h"

namespace gicube::emu {
namespace {

using wire::LightingLedger;

v1::BoardConfig functional(bool wide = false) {
  v1::BoardConfig config;
  config.set_fidelity(v1::functional);
  config.mutable_asic()->set_block_voxels(16);
  config.mutable_asic()->set_datapath(wide ? v1::wide : v1::paper);
  config.set_threads(2);
  return resolve(config);
}

wire::Material trap(std::uint8_t routine, const std::vector<float>& parameters = {}, double scattering = 1) {
  wire::Material material;
  material.bsdf = wire::Bsdf::kTrap;
  material.scattering = static_cast<std::uint16_t>(std::lround(scattering * wire::kScatteringOne));
  material.flags = wire::kScattersRenderingRays;
  material.routine = routine;
  material.parameter_count = static_cast<std::uint8_t>(parameters.size());
  std::copy(parameters.begin(), parameters.end(), material.parameters.begin());
  return material;
}

// A cube full of fog of tag 0, with a light in it.
class Fog {
 public:
  explicit Fog(bool wide = false, const Routines* routines = nullptr, double opacity = 0.2)
      : Fog(functional(wide), routines, opacity) {}
  explicit Fog(const v1::BoardConfig& config, const Routines* routines, double opacity = 0.2)
      : board(config, nullptr, routines) {
    board.load_volume({24, 24, 24}, [](int, int, int) { return wire::Voxel{1000, 0, 0, 0}; });
    board.write_segmentation([opacity](unsigned tag, unsigned) {
      wire::SegmentationEntry entry;
      entry.colour = {4095, 2000, 1000};
      if (tag == 0) entry.opacity = static_cast<std::uint16_t>(opacity * wire::kClassifiedOpacityOne);
      return entry;
    });
    board.write_register(wire::reg::kSeed, 3);
  }

  void set(const wire::Material& material) {
    const auto bytes = wire::encoded(material);
    board.write_memory(wire::kMaterials.base, bytes);
  }

  Completion light(wire::Albedo albedo = wire::Albedo::kLow, double energy = 30'000) {
    wire::IlluminateCommand command;
    command.albedo = albedo;
    command.energy = energy;
    command.position = {11, 12, 13};
    command.rays_per_voxel = command.count = 2;
    const auto payload = wire::encoded(command);
    return board.wait(board.command(payload)).completions.at(0);
  }

  LightingLedger ledger(wire::Albedo albedo = wire::Albedo::kLow, double energy = 30'000) {
    const Completion completion = light(albedo, energy);
    if (completion.error == wire::ErrorCode::kNone && completion.payload.size() == wire::kLightingLedgerBytes) {
      return wire::decode<wire::LightingLedger>(completion.payload);
    }
    ADD_FAILURE() << std::string(completion.payload.begin(), completion.payload.end());
    return {};
  }

  std::string fault() {
    const Completion completion = light();
    return completion.error == wire::ErrorCode::kNone
               ? "none"
               : std::string(completion.payload.begin(), completion.payload.end());
  }

  BareBoard board;
};

RoutineTable fickle_table() {
  RoutineTable table;
  table.add(PlugIn::load(GICUBE_TEST_DIR "/fickle_bsdf.so"));
  return table;
}

std::vector<float> mood(Whim whim, float second = 1) { return {static_cast<float>(whim), second}; }

TEST(TrappedRays, LeaveTheLedgerExact) {
  const RoutineTable table = fickle_table();
  const std::vector<wire::Material> materials{trap(0, {1.4f}), trap(1, {0.7f}, 0.8), trap(2, {1, 0, 3}, 0.9),
                                              trap(kFirstUserRoutine, mood(Whim::kRetroreflect, 0.6f))};
  for (const bool wide : {false, true}) {
    for (const wire::Albedo albedo : {wire::Albedo::kLow, wire::Albedo::kHigh}) {
      for (const wire::Material& material : materials) {
        SCOPED_TRACE(testing::Message() << "routine " << int{material.routine} << (wide ? ", wide" : ""));
        Fog fog(wide, &table);
        fog.set(material);
        const LightingLedger at = fog.ledger(albedo, wide ? 3e9 : 30'000);
        EXPECT_EQ(at.emitted, at.deposited + at.escaped + at.scattered_away + at.clipped);
        EXPECT_GT(at.emitted, 0u);
        EXPECT_GT(fog.board.counter("pipeline.traps"), 1000u);
        const std::uint64_t declared = material.routine == kFirstUserRoutine ? kFickleCycles : 200;
        EXPECT_EQ(fog.board.counter("dsp.trap_cycles"), declared * fog.board.counter("pipeline.traps"));
        EXPECT_EQ(at.scattered_away > at.given_up, material.routine == kFirstUserRoutine) << "its share is dropped";
      }
    }
  }
}

TEST(TrappedRays, CostTheDspTheirCycles) {
  const auto simulated = [](float cycles) {
    const RoutineTable table = fickle_table();
    Fog fog(false, &table);
    fog.set(trap(kFirstUserRoutine, mood(Whim::kCostly, cycles)));
    const Completion completion = fog.light();
    return std::pair(completion.time_ps, fog.board.counter("pipeline.traps"));
  };
  const auto [cheap, traps] = simulated(100);
  const auto [dear, same] = simulated(900);
  EXPECT_EQ(traps, same);
  EXPECT_EQ(dear - cheap, 800 * traps * 5000) << "at 200 MHz";
}

// In a medium that absorbs nothing a ray would bounce for ever.
TEST(TrappedRays, AreGivenUpAtTheEndOfTheirLifetime) {
  const RoutineTable table = fickle_table();
  Fog fog(false, &table, 0.9);
  fog.set(trap(kFirstUserRoutine, mood(Whim::kRetroreflect)));
  fog.board.write_register(wire::reg::kLifetime, 7);
  const LightingLedger at = fog.ledger(wire::Albedo::kHigh);
  EXPECT_EQ(at.deposited, 0u);
  EXPECT_GT(at.given_up, at.emitted / 2);
  EXPECT_EQ(at.emitted, at.escaped + at.given_up);
  EXPECT_LE(fog.board.counter("pipeline.traps"), 7 * at.rays);
}

TEST(TrappedRays, OfABadRoutineFailTheirCommandAndTheBoardGoesOn) {
  const RoutineTable table = fickle_table();
  Fog fog(false, &table);
  const wire::Material good = trap(kFirstUserRoutine, mood(Whim::kRetroreflect));
  fog.set(good);
  const LightingLedger before = fog.ledger();
  for (const Whim whim : {Whim::kNan, Whim::kZero, Whim::kPassesMore, Whim::kThrow, Whim::kRefuse}) {
    fog.set(trap(kFirstUserRoutine, mood(whim)));
    EXPECT_THAT(fog.fault(), HasSubstr("routine 8 \"fickle\": "));
  }
  fog.set(trap(kFirstUserRoutine, mood(Whim::kCostly, 5000)));
  EXPECT_THAT(fog.fault(), HasSubstr("cycles: expected 1..1000, got 5000"));
  fog.set(good);
  fog.board.write_register(wire::reg::kControl, wire::kControlClearIrradiance);
  EXPECT_EQ(fog.ledger(), before);
}

TEST(TrappedRays, OfARoutineThatNeverReturnsFailTheirCommand) {
  const RoutineTable table = fickle_table();
  Fog fog(functional(), &table);
  fog.set(trap(kFirstUserRoutine, mood(Whim::kEndless)));
  for (int round = 0; round < 2; ++round) EXPECT_THAT(fog.fault(), HasSubstr("\"fickle\": did not return within"));
  fog.set(trap(kFirstUserRoutine, mood(Whim::kRetroreflect)));
  EXPECT_EQ(fog.fault(), "none");
}

TEST(TrappedRays, OfARoutineThatEndsItsProcessFailTheirCommandAlikeAtEveryLevel) {
  for (const auto level : {v1::functional, v1::cycle}) {
    SCOPED_TRACE(v1::FidelityLevel_Name(level));
    const RoutineTable table = fickle_table();
    v1::BoardConfig config = functional();
    config.set_fidelity(level);
    Fog fog(config, &table);
    const wire::Material good = trap(kFirstUserRoutine, mood(Whim::kRetroreflect, 0.5f));
    fog.set(good);
    const LightingLedger before = fog.ledger();
    fog.set(trap(kFirstUserRoutine, mood(Whim::kSegfault)));
    EXPECT_EQ(fog.fault(), "routine 8 \"fickle\": its process was ended by signal 11 (Segmentation fault)");
    fog.set(trap(kFirstUserRoutine, mood(Whim::kExit, 0)));
    EXPECT_EQ(fog.fault(), "routine 8 \"fickle\": it ended its process, with exit code 0");
    fog.set(good);
    fog.board.write_register(wire::reg::kControl, wire::kControlClearIrradiance);
    EXPECT_EQ(fog.ledger(), before);
  }
}

TEST(TrappedRays, OfOneBoardGoOnWhileThoseOfAnotherEndTheirProcesses) {
  const RoutineTable table = fickle_table();
  Fog good(functional(), &table), bad(functional(), &table);
  good.set(trap(kFirstUserRoutine, mood(Whim::kRetroreflect, 0.5f)));
  const LightingLedger before = good.ledger();
  std::jthread other([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      for (const Whim whim : {Whim::kSegfault, Whim::kExit}) {
        bad.set(trap(kFirstUserRoutine, mood(whim)));
        EXPECT_THAT(bad.fault(), HasSubstr("process"));
      }
    }
  });
  for (int round = 0; round < 5; ++round) {
    good.board.write_register(wire::reg::kControl, wire::kControlClearIrradiance);
    EXPECT_EQ(good.ledger(), before);
  }
}

TEST(TrappedRays, NeedARoutineThatTheBoardHasWithParametersThatItTakes) {
  Fog fog;
  fog.set(trap(5));
  EXPECT_THAT(fog.fault(),
              HasSubstr("material 0: routine: expected the number of a routine that the board has, got 5"));
  fog.set(trap(kFirstUserRoutine));
  EXPECT_THAT(fog.fault(), HasSubstr("got 8"));
  fog.set(trap(1, {1.5f}));
  EXPECT_THAT(fog.fault(), HasSubstr("material 0: routine 1 \"henyey_greenstein\": g: expected"));
  fog.board.write_register(wire::reg::kPipeline, wire::kPipelineScatter);
  const std::vector<wire::Ray> ray{host_ray(1, {1, 1, 1}, {1, 1, 1})};
  const Completion traced = fog.board.wait(fog.board.command(BareBoard::trace_payload(ray))).completions.at(0);
  EXPECT_EQ(traced.error, wire::ErrorCode::kBadValue) << "host rays are scattered too";
}

}  // namespace
}  // namespace gicube::emu
