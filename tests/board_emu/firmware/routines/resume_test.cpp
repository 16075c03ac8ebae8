// Rays that wait for the host, as commands of the bus: how they are handed out, and which answers are refused.
#include "bare_board.h"
#include "config/config.h"
#include "datapath/host_traps.h"
#include "datapath/scattering.h"
#include "gicube/wire/trap.h"
#include "test.h"

namespace gicube::emu {
namespace {

v1::BoardConfig config_of(unsigned threads, v1::FidelityLevel fidelity = v1::functional) {
  v1::BoardConfig config;
  config.set_fidelity(fidelity);
  config.mutable_asic()->set_block_voxels(16);
  config.set_threads(threads);
  return resolve(config);
}

struct Answered {
  wire::ErrorCode error = wire::ErrorCode::kNone;
  std::string text;
  wire::LightingLedger ledger;
  std::vector<wire::TrappedRay> rays;
  std::uint32_t waiting = 0;
};

// A cube of fog whose scattering is the host's, with one directional light.
class HostFog {
 public:
  explicit HostFog(unsigned threads = 2, v1::FidelityLevel fidelity = v1::functional)
      : HostFog(config_of(threads, fidelity)) {}
  explicit HostFog(const v1::BoardConfig& config) : board(config) { load(); }

  void load() {
    board.load_volume({20, 20, 20}, [](int, int, int) { return wire::Voxel{1000, 0, 2, 0}; });
    board.write_segmentation([](unsigned, unsigned) {
      wire::SegmentationEntry entry;
      entry.opacity = 10'000;
      return entry;
    });
    wire::Material material;
    material.bsdf = wire::Bsdf::kTrap;
    material.routine = wire::kHostRoutine;
    material.scattering = wire::kScatteringOne;
    const auto bytes = wire::encoded(material);
    board.write_memory(wire::kMaterials.base + 2 * wire::kMaterialBytes, bytes);
  }

  Answered light(wire::EnergyRules rules = wire::EnergyRules::kConserving) {
    wire::IlluminateCommand command;
    command.kind = wire::LightKind::kDirectional;
    command.rules = rules;
    command.energy = 100;
    command.u = {0, 0, -1};
    const auto payload = wire::encoded(command);
    return run(payload);
  }

  Answered resume(const std::vector<wire::Ray>& rays, std::uint32_t most) {
    std::vector<std::uint8_t> payload(wire::kResumeHeaderBytes + rays.size() * wire::kRayBytes);
    wire::store(std::span(payload), 0, static_cast<std::uint32_t>(wire::Opcode::kResume));
    wire::store(std::span(payload), 4, static_cast<std::uint32_t>(rays.size()));
    wire::store(std::span(payload), 8, most);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      wire::encode(rays[i], std::span(payload).subspan(wire::kResumeHeaderBytes + i * wire::kRayBytes));
    }
    return run(payload);
  }

  std::string refusal(const std::vector<wire::Ray>& rays, std::uint32_t most = 0) {
    const Answered answered = resume(rays, most);
    return answered.error == wire::ErrorCode::kBadValue ? answered.text : "not refused";
  }

  BareBoard board;

 private:
  Answered run(const std::vector<std::uint8_t>& payload) {
    const Completion completion = board.wait(board.command(payload)).completions.at(0);
    Answered out;
    out.error = completion.error;
    std::span<const std::uint8_t> bytes = completion.payload;
    if (completion.error != wire::ErrorCode::kNone) {
      out.text.assign(bytes.begin(), bytes.end());
      return out;
    }
    out.ledger = wire::decode<wire::LightingLedger>(bytes);
    bytes = bytes.subspan(wire::kLightingLedgerBytes);
    if (bytes.empty()) return out;
    out.waiting = wire::load<std::uint32_t>(bytes, 4);
    EXPECT_EQ(bytes.size(), wire::kTrapListHeaderBytes + wire::load<std::uint32_t>(bytes, 0) * wire::kTrappedRayBytes);
    for (std::size_t at = wire::kTrapListHeaderBytes; at < bytes.size(); at += wire::kTrappedRayBytes)
      out.rays.push_back(wire::decode<wire::TrappedRay>(bytes.subspan(at)));
    return out;
  }
};

std::vector<wire::Ray> straight_on(const std::vector<wire::TrappedRay>& trapped) {
  std::vector<wire::Ray> rays;
  for (const wire::TrappedRay& each : trapped) {
    rays.push_back(each.ray);
    wire::set_dropped_share(rays.back(), 0);
  }
  return rays;
}

TEST(HostTraps, AreHandedOutInRoundsInTheOrderOfTheirRays) {
  std::vector<wire::TrappedRay> all;
  for (const unsigned threads : {1u, 2u}) {
    HostFog fog(threads);
    const Answered lit = fog.light();
    ASSERT_EQ(lit.error, wire::ErrorCode::kNone) << lit.text;
    EXPECT_TRUE(lit.rays.empty()) << "they are fetched";
    ASSERT_GT(lit.waiting, 100u);
    std::vector<wire::TrappedRay> rays;
    std::uint32_t waiting = lit.waiting;
    while (waiting > 0) {
      const Answered round = fog.resume({}, 37);
      EXPECT_EQ(round.rays.size() + round.waiting, waiting);
      EXPECT_EQ(round.rays.size(), std::min<std::size_t>(37, waiting));
      rays.insert(rays.end(), round.rays.begin(), round.rays.end());
      waiting = round.waiting;
    }
    EXPECT_TRUE(std::is_sorted(rays.begin(), rays.end(),
                               [](const auto& a, const auto& b) { return a.ray.host_id() < b.ray.host_id(); }));
    for (const wire::TrappedRay& each : rays) {
      EXPECT_EQ(each.tag, 2);
      EXPECT_EQ(each.ray.flags, wire::kLightingRay);
    }
    if (all.empty()) all = rays;
    EXPECT_EQ(rays, all) << "whatever the threads";
  }
}

TEST(HostTraps, CarryTheirEnergyThroughEveryRound) {
  HostFog fog;
  const Answered lit = fog.light();
  std::uint64_t accounted = lit.ledger.deposited + lit.ledger.escaped + lit.ledger.scattered_away + lit.ledger.clipped;
  std::uint64_t carried = lit.ledger.emitted - accounted, ended = lit.ledger.rays;
  Answered round = fog.resume({}, 1000);
  while (!round.rays.empty() || round.waiting > 0) {
    round = fog.resume(straight_on(round.rays), 1000);
    ASSERT_EQ(round.error, wire::ErrorCode::kNone) << round.text;
    const wire::LightingLedger& at = round.ledger;
    carried -= at.deposited + at.escaped + at.scattered_away + at.clipped;
    ended += at.rays;
  }
  EXPECT_EQ(carried, 0u);
  EXPECT_GT(ended, 300u);
  EXPECT_EQ(round.waiting, 0u);
}

TEST(HostTraps, RefuseAnswersThatNoRayOfTheirsCanBe) {
  HostFog fog;
  EXPECT_THAT(fog.refusal({wire::Ray{}}),
              HasSubstr("count: expected at most the number of rays that were handed out and not answered, 0"));
  fog.light();
  const std::vector<wire::Ray> rays = straight_on(fog.resume({}, 2).rays);
  ASSERT_EQ(rays.size(), 2u);
  const auto refusal = [&](auto change) {
    std::vector<wire::Ray> changed = rays;
    change(changed[1]);
    return fog.refusal(changed);
  };
  EXPECT_THAT(refusal([](wire::Ray& ray) { ray.position[2] = wire::kPositionMax; }), HasSubstr("ray 1: position"));
  EXPECT_THAT(refusal([](wire::Ray& ray) { ray.direction = {}; }), HasSubstr("ray 1: direction"));
  EXPECT_THAT(refusal([](wire::Ray& ray) { ray.lifetime = 0; }), HasSubstr("ray 1: lifetime"));
  EXPECT_THAT(refusal([](wire::Ray& ray) { ray.flags = 0; }), HasSubstr("ray 1: flags: expected a lighting ray"));
  EXPECT_THAT(fog.refusal({rays[0], rays[0], rays[1]}), HasSubstr("handed out and not answered, 2, got 3"));
  EXPECT_THAT(fog.refusal({}, 65537), HasSubstr("max_rays: expected 0..65536, got 65537"));
  EXPECT_EQ(fog.resume(rays, 0).error, wire::ErrorCode::kNone) << "nothing of that was taken";
  EXPECT_THAT(fog.refusal({rays[0]}), HasSubstr("answered, 0, got 1"));
  std::vector<std::uint8_t> cut(20);
  wire::store(std::span(cut), 0, static_cast<std::uint32_t>(wire::Opcode::kResume));
  wire::store(std::span(cut), 4, 1u);
  EXPECT_EQ(fog.board.wait(fog.board.command(cut)).completions.at(0).error, wire::ErrorCode::kBadValue);
}

TEST(HostTraps, AreForgottenByTheNextCommandThatMakesRays) {
  HostFog fog;
  const Answered first = fog.light();
  fog.resume({}, 5);
  const Answered second = fog.light();
  EXPECT_EQ(second.waiting, first.waiting);
  EXPECT_THAT(fog.refusal({wire::Ray{}}), HasSubstr("answered, 0"));
}

TEST(HostTraps, AreForgottenByAReset) {
  HostFog fog;
  ASSERT_GT(fog.light().waiting, 100u);
  ASSERT_EQ(fog.resume({}, 3).rays.size(), 3u);
  fog.board.write_register(wire::reg::kControl, wire::kControlReset);
  fog.load();
  EXPECT_THAT(fog.refusal({wire::Ray{}}), HasSubstr("answered, 0, got 1"));
  std::vector<std::uint8_t> payload(wire::kResumeHeaderBytes);
  wire::encode(wire::ResumeHeader{0, 100}, payload);
  EXPECT_TRUE(fog.board.wait(fog.board.command(payload)).completions.at(0).payload.empty())
      << "no rays, and no ledger of a light";
}

TEST(HostTraps, CostTheDspThePassingOnOfARay) {
  for (const bool ideal : {false, true}) {
    v1::BoardConfig config = config_of(1);
    config.mutable_ideal()->set_dsp(ideal ? 1 : 0);
    HostFog fog(config);
    fog.light();
    const std::uint64_t before = fog.board.counter("dsp.busy_ps");
    ASSERT_EQ(fog.resume({}, 30).rays.size(), 30u);
    const double busy_ps = static_cast<double>(fog.board.counter("dsp.busy_ps") - before);
    EXPECT_NEAR(busy_ps * config.dsp().clock_khz() * 1e-9, ideal ? 0 : 30 * 8, 0.01);
    EXPECT_EQ(fog.board.counter("dsp.host_traps"), 30u);
  }
}

// All that does not absorb scatters: by the printed rules a ray loses its opacity all the same, by the others nothing.
TEST(HostTraps, GoOnByTheRulesOfTheirLight) {
  for (const wire::EnergyRules rules : {wire::EnergyRules::kConserving, wire::EnergyRules::kAsPrinted}) {
    HostFog fog;
    ASSERT_GT(fog.light(rules).waiting, 100u);
    const Answered round = fog.resume(straight_on(fog.resume({}, 100).rays), 0);
    ASSERT_EQ(round.error, wire::ErrorCode::kNone) << round.text;
    EXPECT_EQ(round.ledger.scattered_away > 0, rules == wire::EnergyRules::kAsPrinted);
    EXPECT_EQ(round.ledger.deposited, 0u);
  }
}

TEST(HostTraps, HaveALimit) {
  HostTraps traps;
  traps.begin(true, {});
  for (std::size_t i = 0; i < HostTraps::kMax; ++i) traps.add({});
  EXPECT_THROW(traps.add({}), RoutineFault);
}

}  // namespace
}  // namespace gicube::emu
