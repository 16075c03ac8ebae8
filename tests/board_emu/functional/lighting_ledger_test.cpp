// Where lighting rays leave their energy: every unit of it, and the same in every copy of a voxel.
#include "bare_board.h"
#include "config/config.h"
#include "lighting_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

using wire::Albedo;
using wire::Bsdf;
using wire::EnergyRules;
using wire::IlluminateCommand;
using wire::LightingLedger;
using wire::LightKind;

// Draws scenes: fog, solids and empty space of four tags, materials of every kind that the pipeline scatters by itself,
// and lights inside and outside.
class Chaos {
 public:
  explicit Chaos(unsigned seed) : random_(seed) {}

  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  std::array<double, 3> point(double low, double high) { return {real(low, high), real(low, high), real(low, high)}; }

  std::array<int, 3> size() { return {whole(9, 36), whole(9, 36), whole(9, 36)}; }

  VoxelField voxels() {
    const std::array<double, 3> wave = point(0.1, 0.6);
    const auto salt = static_cast<unsigned>(whole(0, 1000));
    return [wave, salt](int x, int y, int z) {
      const double level = std::sin(wave[0] * x) * std::sin(wave[1] * y + 1) * std::sin(wave[2] * z + 2);
      wire::Voxel voxel;
      voxel.density = static_cast<std::uint16_t>(2048 + 2000 * level);
      voxel.gradient = static_cast<std::uint16_t>((salt + static_cast<unsigned>(x * 31 + y * 17 + z)) % 2048);
      voxel.tag = static_cast<std::uint8_t>((x / 5 + y / 7 + z / 3) % 4);
      return voxel;
    };
  }

  wire::SegmentationEntry classified(unsigned tag, unsigned density) {
    wire::SegmentationEntry entry;
    if (density < 1500) return entry;
    entry.opacity = tag == 3 && density > 3000 ? wire::kClassifiedOpacityOne
                                               : static_cast<std::uint16_t>(opacity_[tag] * (density - 1500) / 2600);
    return entry;
  }

  wire::Material material() {
    wire::Material material;
    material.bsdf = static_cast<Bsdf>(whole(0, 5));
    material.scattering = static_cast<std::uint16_t>(whole(0, 3) == 0 ? wire::kScatteringOne : whole(0, 65535));
    material.gloss = static_cast<std::uint16_t>(whole(0, 8192));
    return material;
  }

  IlluminateCommand light(Albedo albedo, EnergyRules rules, bool wide) {
    IlluminateCommand command;
    command.kind = static_cast<LightKind>(whole(0, 3));
    command.albedo = albedo;
    command.rules = rules;
    command.rays_per_voxel = static_cast<std::uint32_t>(whole(1, 12));
    command.first = static_cast<std::uint32_t>(whole(0, static_cast<int>(command.rays_per_voxel) - 1));
    command.count = command.rays_per_voxel - command.first;
    command.position = point(-5, 30);
    command.u = point(0.5, 9);
    command.v = {-command.u[1], command.u[0] + 1, real(-4, 4)};
    command.energy = std::pow(10, real(3, 7)) * (wide ? 65536 : 1);
    if (command.kind == LightKind::kDirectional) command.energy /= 100;
    return command;
  }

 private:
  std::mt19937 random_;
  std::array<double, 4> opacity_{3000, 65535, 20000, 50000};
};

v1::BoardConfig functional(bool wide, int block_voxels) {
  v1::BoardConfig config;
  config.set_fidelity(v1::functional);
  config.mutable_asic()->set_block_voxels(static_cast<std::uint32_t>(block_voxels));
  config.mutable_asic()->set_datapath(wide ? v1::wide : v1::paper);
  config.set_threads(2);
  return resolve(config);
}

Completion illuminate(BareBoard& board, const IlluminateCommand& command) {
  const auto payload = wire::encoded(command);
  return board.wait(board.command(payload)).completions.at(0);
}

LightingLedger ledger(const Completion& completion) {
  if (completion.error != wire::ErrorCode::kNone) {
    ADD_FAILURE() << std::string(completion.payload.begin(), completion.payload.end());
    return {};
  }
  return wire::decode<wire::LightingLedger>(completion.payload);
}

// The sum of all voxels' irradiance words, as the host reads them.
std::uint64_t irradiance_sum(BareBoard& board, const std::array<int, 3>& size, int n) {
  std::uint64_t words = 1, sum = 0;
  for (const int voxels : size) words *= static_cast<std::uint64_t>((voxels + n - 1) / n * n);
  const Reply reply = board.read_memory(wire::kIrradiance.base, words * wire::kIrradianceBytes);
  for (std::uint64_t i = 0; i < words; ++i)
    sum += wire::load<std::uint32_t>(reply.payload, static_cast<std::size_t>(i * wire::kIrradianceBytes));
  return sum;
}

void write_material(BareBoard& board, unsigned tag, const wire::Material& material) {
  const auto bytes = wire::encoded(material);
  board.write_memory(wire::kMaterials.base + tag * wire::kMaterialBytes, bytes);
}

TEST(LightingLedger, ClosesToTheUnitForRandomScenes) {
  std::uint64_t clipped = 0, given_up = 0, scattered_away = 0;
  std::array<std::uint64_t, wire::kFaces> escaped{};
  for (unsigned seed = 0; seed < 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Chaos chaos(seed);
    const Albedo albedo = (seed & 1) != 0 ? Albedo::kHigh : Albedo::kLow;
    const EnergyRules rules = (seed & 2) != 0 ? EnergyRules::kConserving : EnergyRules::kAsPrinted;
    const bool wide = (seed & 4) != 0;
    const int n = (seed & 8) != 0 ? 8 : 16;
    const std::array<int, 3> size = chaos.size();
    BareBoard board(functional(wide, n));
    board.load_volume(size, chaos.voxels());
    board.write_segmentation([&](unsigned tag, unsigned density) { return chaos.classified(tag, density); });
    for (unsigned tag = 0; tag < wire::kTags; ++tag) write_material(board, tag, chaos.material());
    board.write_register(wire::reg::kSpacingY, static_cast<std::uint32_t>(chaos.real(0.5, 3) * wire::kSpacingOne));
    board.write_register(wire::reg::kStep, static_cast<std::uint32_t>(chaos.real(0.2, 2.5) * wire::kStepOne));
    board.write_register(wire::reg::kOpacityThreshold, wire::kOpacityOne);
    board.write_register(wire::reg::kLifetime, static_cast<std::uint32_t>(chaos.whole(0, 40)));
    board.write_register(wire::reg::kSeed, seed);
    board.write_register(wire::reg::kPipeline, chaos.whole(0, 1) != 0 ? wire::kPipelineJitter : 0u);

    std::uint64_t deposited = 0;
    for (int light = 0; light < 3; ++light) {  // each adds to those before
      IlluminateCommand command = chaos.light(albedo, rules, wide);
      if (light == 2) {  // so bright that every ray is full
        command.kind = LightKind::kPoint;
        command.position = {size[0] / 2.0, size[1] / 3.0, size[2] / 2.0};
        command.energy = wide ? 1e13 : 1e8;
      }
      const LightingLedger at = ledger(illuminate(board, command));
      EXPECT_EQ(at.emitted, at.deposited + at.escaped + at.scattered_away + at.clipped);
      EXPECT_EQ(std::reduce(at.escaped_by_face.begin(), at.escaped_by_face.end()), at.escaped);
      EXPECT_LE(at.given_up, at.scattered_away);
      if (rules == EnergyRules::kConserving || albedo == Albedo::kHigh) {
        EXPECT_EQ(at.given_up, at.scattered_away) << "nothing else is lost";
      }
      deposited += at.deposited;
      clipped += at.clipped;
      given_up += at.given_up;
      scattered_away += at.scattered_away - at.given_up;
      for (std::size_t face = 0; face < escaped.size(); ++face) escaped[face] += at.escaped_by_face[face];
    }
    EXPECT_EQ(irradiance_sum(board, size, n), deposited);
    board.write_register(wire::reg::kControl, wire::kControlClearIrradiance);
    EXPECT_EQ(irradiance_sum(board, size, n), 0u);
  }
  EXPECT_GT(clipped, 0u);  // the scenes reach every column
  EXPECT_GT(given_up, 0u);
  EXPECT_GT(scattered_away, 0u);
  EXPECT_EQ(std::ranges::count(escaped, 0u), 0) << "a face by which nothing leaves";
}

TEST(LightingLedger, EmitsWhatItsRaysCarry) {
  Chaos chaos(5);
  BareBoard board(functional(false, 16));
  board.load_volume({20, 17, 24}, chaos.voxels());
  const IlluminateCommand command = light_of(LightKind::kPoint, 50'000, {3, 4, 5}, 4);
  board.write_register(wire::reg::kSeed, 77);
  const LightingLedger at = ledger(illuminate(board, command));
  const LightingRays rays(command, {19 * wire::kVoxel, 16 * wire::kVoxel, 23 * wire::kVoxel},
                          {wire::kSpacingOne, wire::kSpacingOne, wire::kSpacingOne}, 8, 77);
  std::uint64_t count = 0, emitted = 0;
  for (std::uint64_t i = 0; i < rays.count(); ++i) {
    if (const auto ray = rays.make(i)) ++count, emitted += ray->colour_word() >> kEnergyFractionBits;
  }
  EXPECT_EQ(at.rays, count);
  EXPECT_EQ(at.emitted, emitted);
  EXPECT_NEAR(static_cast<double>(emitted), 50'000, 400);
  EXPECT_EQ(at.escaped, emitted) << "nothing has an opacity";
}

TEST(LightingLedger, SaysThatALightStandsInASolid) {
  BareBoard board(functional(false, 16));
  board.load_volume({16, 16, 16}, [](int, int, int) { return wire::Voxel{}; });
  board.write_segmentation([](unsigned, unsigned) {
    wire::SegmentationEntry entry;
    entry.opacity = wire::kClassifiedOpacityOne;
    return entry;
  });
  const LightingLedger inside = ledger(illuminate(board, light_of(LightKind::kPoint, 1000, {8, 8, 8}, 1)));
  EXPECT_EQ(inside.light_in_solid, 1u);
  EXPECT_EQ(inside.escaped, 0u);
  EXPECT_EQ(ledger(illuminate(board, light_of(LightKind::kPoint, 1000, {8, 8, -8}, 1))).light_in_solid, 0u);
}

TEST(LightingLedger, RefusesWhatItCannotLight) {
  BareBoard board(functional(false, 16));
  const auto text = [&](const IlluminateCommand& command) {
    const Completion completion = illuminate(board, command);
    EXPECT_NE(completion.error, wire::ErrorCode::kNone);
    return std::string(completion.payload.begin(), completion.payload.end());
  };
  EXPECT_THAT(text(light_of(LightKind::kPoint, 1, {}, 1)), HasSubstr("no volume"));
  board.load_volume({16, 16, 16}, [](int, int, int) { return wire::Voxel{}; });
  EXPECT_THAT(text(light_of(LightKind::kPoint, -1, {}, 1)), HasSubstr("energy"));
  EXPECT_THAT(text(light_of(LightKind::kRectangle, 1, {}, 1)), HasSubstr("rectangle"));
}

// Voxels on the faces that blocks share have up to seven copies.
TEST(IrradianceCopies, AreEqualAfterThePass) {
  for (const bool wide : {false, true}) {
    for (const Albedo albedo : {Albedo::kLow, Albedo::kHigh}) {
      LitScene lit({29, 17, 24}, 8, wide);
      lit.medium(0.05, 0.7, Bsdf::kIsotropic);
      // With the paper's words many voxels saturate.
      IlluminateCommand command = light_of(LightKind::kPoint, wide ? 1e9 : 1e6, {8, 8, 8}, 16, albedo);
      const RayCounters counters = lit.light(command);
      EXPECT_EQ(counters.energy.deposited.clipped > 0, !wide);
      int copies = 0, lit_copies = 0;
      const auto& blocks = lit.scene.volume.blocks();
      for (std::size_t block = 0; block < lit.scene.volume.block_count(); ++block) {
        const std::uint32_t* words = lit.irradiance.view(block);
        const auto b = static_cast<int>(block);
        const std::array<int, 3> low{b % blocks[0] * 8, b / blocks[0] % blocks[1] * 8, b / (blocks[0] * blocks[1]) * 8};
        for (int i = 0; i < 9 * 9 * 9; ++i) {
          const std::array<int, 3> local{i % 9, i / 9 % 9, i / 81};
          if (local[0] < 8 && local[1] < 8 && local[2] < 8) continue;  // its own
          const int x = low[0] + local[0], y = low[1] + local[1], z = low[2] + local[2];
          if (x >= 29 || y >= 17 || z >= 24) continue;
          const std::uint32_t copy = words == nullptr ? 0 : words[i];
          ASSERT_EQ(copy, lit.irradiance_at(x, y, z)) << x << " " << y << " " << z << " in block " << block;
          ++copies;
          lit_copies += copy != 0;
        }
      }
      EXPECT_GT(copies, 1000);
      EXPECT_GT(lit_copies, albedo == Albedo::kLow ? copies / 2 : 100);
    }
  }
}

}  // namespace
}  // namespace gicube::emu
