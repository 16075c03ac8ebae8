// Host rays of every type through random machines give the bits of the functional level: the rays that come back, the
// ledgers of those that deposit, and the irradiance and the sums that they leave.
#include "gicube/wire/material.h"
#include "random_machine.h"
#include "seeds.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr std::array<int, 3> kSize{30, 21, 26};
constexpr std::uint64_t kIrradianceBytes = 64 * 8 * 8 * 8;

void load(BareBoard& board, Dice& dice, int n) {
  const int radius = dice.number(5, 14), floor = dice.number(0, 8), peak = dice.one_of({400, 9000, 65535});
  board.load_volume(kSize, [&](int x, int y, int z) {
    const int dx = x - 15, dy = y - 10, dz = z - 13, inside = radius * radius - dx * dx - dy * dy - dz * dz;
    wire::Voxel voxel;
    voxel.density = static_cast<std::uint16_t>(inside > 0 ? std::min(4095, 900 + inside * 30) : z < floor ? 1200 : 0);
    voxel.gradient = static_cast<std::uint16_t>((x * 7 + y * 131 + z * 31) % 2048);
    voxel.tag = static_cast<std::uint8_t>(x < 15 ? 0 : 1);
    return voxel;
  });
  board.write_segmentation([peak](unsigned tag, unsigned density) {
    return wire::SegmentationEntry{
        {static_cast<std::uint16_t>(density), 2000, static_cast<std::uint16_t>(3000 * (tag & 1))},
        static_cast<std::uint16_t>(density < 600 ? 0 : std::min(65535u, static_cast<unsigned>(peak) * density / 4096))};
  });
  for (std::size_t tag = 0; tag < 2; ++tag) {
    wire::Material material;
    material.bsdf = dice.one_of({wire::Bsdf::kNone, wire::Bsdf::kIsotropic, wire::Bsdf::kDiffuse});
    material.scattering = static_cast<std::uint16_t>(dice.one_of({0, 30'000, 60'000}));
    material.flags = wire::kScattersRenderingRays;
    const auto bytes = wire::encoded(material);
    board.write_memory(wire::kMaterials.base + tag * wire::kMaterialBytes, bytes);
  }
  std::vector<std::uint8_t> flags(wire::kEmptyFlags.bytes);
  const int blocks = ((kSize[0] + n - 1) / n) * ((kSize[1] + n - 1) / n) * ((kSize[2] + n - 1) / n);
  for (int i = 0; i < blocks; ++i) {  // a wrong flag changes both levels alike
    if (dice.chance(25)) flags[static_cast<std::size_t>(i) / 8] |= static_cast<std::uint8_t>(1 << (i % 8));
  }
  board.write_memory(wire::kEmptyFlags.base, flags);
  board.write_register(wire::reg::kStep, static_cast<std::uint32_t>(dice.one_of({9'000, 32'768, 65'536, 150'000})));
  board.write_register(wire::reg::kPipeline, (dice.chance(50) ? wire::kPipelineJitter : 0u) |
                                                 (dice.chance(50) ? wire::kPipelineShade : 0u) |
                                                 (dice.chance(70) ? wire::kPipelineLeap : 0u) |
                                                 (dice.chance(30) ? wire::kPipelineScatter : 0u) |
                                                 (dice.chance(30) ? wire::kPipelineIrradiance : 0u));
  board.write_register(wire::reg::kExposure, 65536);
  board.write_register(wire::reg::kLifetime, 5);
}

std::vector<wire::Ray> draw_rays(Dice& dice, const wire::TraceHeader& header, bool wide) {
  const int max_amount = dice.one_of({300, 20'000, 2'000'000});
  std::vector<wire::Ray> rays;
  for (int i = dice.number(1, 80); i > 0; --i) {
    std::array<double, 3> position{}, direction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = dice.number(0, (kSize[axis] - 1) * 100) / 100.0;
      direction[axis] = dice.number(-100, 100) + 0.5;
    }
    wire::Ray ray = host_ray(static_cast<std::uint32_t>(i), position, direction);
    switch (header.type) {
      case wire::RayType::kSegment:
      case wire::RayType::kOpacity:
      case wire::RayType::kIntegral:
      case wire::RayType::kBackproject:
        ray.set_colour_word(static_cast<std::uint64_t>(dice.one_of({0, 1, 700, dice.number(0, 60 << 16)})));
        if (header.type == wire::RayType::kBackproject) {
          const int least = header.words == wire::SumWords::kWhole ? -max_amount : 0;
          ray.opacity = static_cast<std::uint32_t>(dice.number(least, max_amount)) & wire::kOpacityOne;
        }
        break;
      case wire::RayType::kDeposit:
        ray.flags |= wire::kLightingRay;
        if (header.albedo == wire::Albedo::kHigh) ray.flags |= wire::kHighAlbedo;
        ray.lifetime = static_cast<std::uint16_t>(dice.number(0, 9));
        ray.set_colour_word(static_cast<std::uint64_t>(dice.number(1, wide ? 1 << 30 : 15 << 12)));
        break;
      default: break;
    }
    rays.push_back(ray);
  }
  return rays;
}

class RayTypesOnRandomMachines : public testing::TestWithParam<unsigned> {};

TEST_P(RayTypesOnRandomMachines, GiveTheBitsOfTheFunctionalLevel) {
  Dice dice(GetParam());
  const int n = dice.one_of({8, 16});
  std::vector<std::string> assignments = draw_machine(dice, n);
  const bool wide = dice.chance(50);
  assignments.push_back(wide ? "asic.datapath=wide" : "asic.datapath=paper");
  if (wide) assignments.push_back("cache.irradiance=with_voxels");  // wide words do not fit a cell's packet
  assignments.push_back("asic.max_volume_voxels=64");
  assignments.push_back("threads=1");
  SCOPED_TRACE(text(assignments));
  v1::BoardConfig config = config_with(assignments);
  config.set_fidelity(v1::cycle);
  BareBoard cycle(config);
  config.set_fidelity(v1::functional);
  config.set_threads(3);
  BareBoard functional(config);
  Dice first(GetParam() + 1000), second(GetParam() + 1000);
  load(cycle, first, n);
  load(functional, second, n);

  const int blocks = ((kSize[0] + n - 1) / n) * ((kSize[1] + n - 1) / n) * ((kSize[2] + n - 1) / n);
  for (int turn = 0; turn <= 9; ++turn) {  // sums once more: caches and bounds go on from before
    const int type = std::min(turn, 6);
    wire::TraceHeader header;
    header.type = static_cast<wire::RayType>(type);
    const bool in_irradiance = turn % 2 == 0 && config.asic().irradiance_words() == 1;
    if (type == 6) header.words = in_irradiance ? wire::SumWords::kIrradiance : wire::SumWords::kWhole;
    if (type >= 1 && type <= 3) {
      header.opacity = dice.one_of<std::uint32_t>({1, wire::kOpacityOne / 3, wire::kOpacityOne});
    }
    if (type == 4) {
      header.albedo = dice.chance(50) ? wire::Albedo::kHigh : wire::Albedo::kLow;
      header.rules = dice.chance(50) ? wire::EnergyRules::kAsPrinted : wire::EnergyRules::kConserving;
    }
    const auto rays = draw_rays(dice, header, wide);
    const auto payload = BareBoard::trace_payload(rays, header);
    const Completion expected = functional.wait(functional.command(payload)).completions.at(0);
    const Completion got = cycle.wait(cycle.command(payload)).completions.at(0);
    ASSERT_EQ(expected.error, wire::ErrorCode::kNone) << std::string(expected.payload.begin(), expected.payload.end());
    EXPECT_EQ(got.error, wire::ErrorCode::kNone);
    EXPECT_EQ(got.payload, expected.payload) << "type " << type;
    if (header.words == wire::SumWords::kWhole) {
      const auto bytes = static_cast<std::uint64_t>(blocks) * wire::packed36_bytes(static_cast<std::size_t>(n * n * n));
      const Reply sums = functional.read_memory(wire::kSums.base, bytes);
      ASSERT_EQ(sums.payload.size(), bytes);
      EXPECT_EQ(cycle.read_memory(wire::kSums.base, bytes).payload, sums.payload);
      continue;
    }
    if (type == 6) {
      const auto ledger = wire::decode<wire::DepositLedger>(expected.payload);
      EXPECT_EQ(ledger.rays, rays.size());
      EXPECT_EQ(ledger.overflowed, 0u);
      EXPECT_EQ(cycle.read_memory(wire::kIrradiance.base, kIrradianceBytes).payload,
                functional.read_memory(wire::kIrradiance.base, kIrradianceBytes).payload);
    }
    if (type != 4) continue;
    const auto ledger = wire::decode<wire::LightingLedger>(expected.payload);
    EXPECT_EQ(ledger.rays, rays.size());
    EXPECT_EQ(ledger.emitted, ledger.deposited + ledger.escaped + ledger.scattered_away + ledger.clipped);
    EXPECT_EQ(cycle.read_memory(wire::kIrradiance.base, kIrradianceBytes).payload,
              functional.read_memory(wire::kIrradiance.base, kIrradianceBytes).payload);
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, RayTypesOnRandomMachines, seeds(100));

}  // namespace
}  // namespace gicube::emu
