// The DSP's commands through the board's connector: what each field may hold, what counts and what comes back, worked by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "bare_board.h"
#include "firmware/framebuffer.h"
#include "firmware/lighting_rays.h"
#include "firmware/ray_sources/image_rays.h"
#include "firmware/vectors.h"
#include "gicube/wire/pair.h"

namespace gicube::emu {
namespace {

namespace reg = wire::reg;

v1::BoardConfig blocks_of_eight(v1::FidelityLevel level = v1::functional) {
  v1::BoardConfig config;
  config.set_fidelity(level);
  config.mutable_asic()->set_block_voxels(8);
  config.set_threads(1);
  return config;
}

// 17^3 voxels of one opacity.
void load_fog(BareBoard& board, std::uint16_t opacity) {
  board.load_volume({17, 17, 17}, [](int, int, int) { return wire::Voxel{1000, 0, 0, 0}; });
  board.write_segmentation([opacity](unsigned, unsigned) {
    return wire::SegmentationEntry{{2048, 2048, 2048}, opacity};
  });
}

Completion carry_out(BareBoard& board, const std::vector<std::uint8_t>& payload) {
  return board.wait(board.command(payload)).completions.at(0);
}
std::string refusal(BareBoard& board, const std::vector<std::uint8_t>& payload) {
  const Completion done = carry_out(board, payload);
  return done.error == wire::ErrorCode::kNone ? "accepted" : std::string(done.payload.begin(), done.payload.end());
}

TEST(Registers, TakeTheLimitsOfEachFieldAndKeepTheirValueBeyond) {
  BareBoard board(blocks_of_eight());
  struct Case {
    std::uint32_t offset, low, high;
  };
  for (const Case& it : {Case{reg::kStep, 1024, 1 << 20},
                         {reg::kSpacingX, 1024, 64 << 16},
                         {reg::kSpacingY, 1024, 64 << 16},
                         {reg::kSpacingZ, 1024, 64 << 16},
                         {reg::kOpacityThreshold, 0, (1 << 24) - 1},
                         {reg::kPipeline, 0, 63},
                         {reg::kLifetime, 0, 1023},
                         {reg::kCutPlanes, 0, 6},
                         {reg::kVolumeX, 2, 256}}) {
    for (const std::uint32_t good : {it.low, it.high}) {
      board.write_register(it.offset, good);
      EXPECT_EQ(board.read_register(it.offset), good) << it.offset;
      EXPECT_EQ(board.read_register(reg::kStatus), 0u) << it.offset << ' ' << good;
    }
    for (const std::uint32_t bad : {it.low - 1, it.high + 1}) {
      if (bad == ~0u) continue;
      board.write_register(it.offset, bad);
      EXPECT_EQ(board.read_register(it.offset), it.high) << it.offset;
      EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadValue) << it.offset << ' ' << bad;
      EXPECT_EQ(board.read_register(reg::kErrorAddress), it.offset);
      board.write_register(reg::kStatusClear, ~0u);
    }
  }
  board.write_register(reg::kStep, 1);
  board.write_register(reg::kControl, wire::kControlReset);
  EXPECT_EQ(board.read_register(reg::kErrorAddress), 0u);
  EXPECT_EQ(board.read_register(reg::kStatus), 0u);
}

// Words of 4 bytes: nothing between them, and nothing of a part of one.
TEST(Irradiance, IsWrittenAndReadByWholeWords) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  const auto status_of = [&board](std::uint64_t offset, std::vector<std::uint8_t> bytes) {
    board.write_memory(wire::kIrradiance.base + offset, bytes);
    const std::uint32_t status = board.read_register(reg::kStatus);
    board.write_register(reg::kStatusClear, ~0u);
    return status;
  };
  EXPECT_EQ(status_of(4, {100, 0, 0, 0}), 0u);
  EXPECT_EQ(status_of(8, {1, 2, 0, 0, 7, 0, 0, 0}), 0u);
  EXPECT_EQ(status_of(3, {9, 9, 9, 9}), wire::kStatusBadAddress);
  EXPECT_EQ(status_of(12, {9, 9, 9}), wire::kStatusBadAddress);
  EXPECT_EQ(status_of(6, {9, 9, 9, 9, 9, 9}), wire::kStatusBadAddress);
  EXPECT_EQ(board.read_memory(wire::kIrradiance.base, 16).payload,
            (std::vector<std::uint8_t>{0, 0, 0, 0, 100, 0, 0, 0, 1, 2, 0, 0, 7, 0, 0, 0}));
  EXPECT_NE(board.read_memory(wire::kIrradiance.base + 2, 4).error, wire::ErrorCode::kNone);
}

TEST(TraceCommand, HasOnlyWhatItsTypeNeeds) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 1000);
  const auto refused = [&board](const wire::TraceHeader& header, wire::Ray ray = host_ray(0, {1, 1, 1}, {0, 0, 1})) {
    return refusal(board, BareBoard::trace_payload({ray}, header));
  };
  using wire::RayType;
  EXPECT_EQ(refused({.type = static_cast<RayType>(7)}), "type: expected 0..6, got 7");
  EXPECT_EQ(refused({.albedo = wire::Albedo::kHigh}), "albedo: expected 0, got 1");
  EXPECT_EQ(refused({.rules = wire::EnergyRules::kConserving}), "rules: expected 0, got 1");
  EXPECT_EQ(refused({.words = wire::SumWords::kWhole}), "words: expected 0, got 1");
  EXPECT_EQ(refused({.type = RayType::kDeposit, .albedo = static_cast<wire::Albedo>(2)}),
            "albedo: expected 0 or 1, got 2");
  EXPECT_EQ(refused({.type = RayType::kBackproject, .words = static_cast<wire::SumWords>(2)}),
            "words: expected 0 or 1, got 2");
  EXPECT_EQ(refused({.opacity = 5}), "opacity: expected 0, got 5");
  EXPECT_EQ(refused({.type = RayType::kFirstHit}), "opacity: expected 1..2^24 - 1, got 0");
  EXPECT_EQ(refused({.type = RayType::kFirstHit, .opacity = 1}), "accepted");
  EXPECT_EQ(refused({.type = RayType::kFirstHit, .opacity = 1 << 24}), "opacity: expected 1..2^24 - 1, got 16777216");
  wire::Ray light = host_ray(0, {1, 1, 1}, {0, 0, 1});
  light.flags |= wire::kLightingRay;
  const auto energy = [&](std::uint64_t word) {
    light.set_colour_word(word);
    return refused({.type = RayType::kDeposit}, light);
  };
  EXPECT_EQ(energy(0), "ray 0: energy: expected 1..1044480 (24.12), got 0");
  EXPECT_EQ(energy(1044481), "ray 0: energy: expected 1..1044480 (24.12), got 1044481");
  EXPECT_EQ(energy(1044480), "accepted");
  wire::Ray way = host_ray(0, {1, 1, 1}, {0, 0, 1});
  way.set_colour_word((4096ull << 16) + 1);
  EXPECT_EQ(refused({.type = RayType::kOpacity, .opacity = 9}, way),
            "ray 0: length: expected 0..4096 voxels in 16.16, got 268435457");
  way.set_colour_word(4096ull << 16);
  EXPECT_EQ(refused({.type = RayType::kOpacity, .opacity = 9}, way), "accepted");
  way.set_colour_word(4 << 16);
  const auto amount = [&](std::int32_t units, wire::SumWords words) {
    way.opacity = static_cast<std::uint32_t>(units) & wire::kOpacityOne;
    return refused({.type = RayType::kBackproject, .words = words}, way);
  };
  EXPECT_EQ(amount((1 << 23) - 1, wire::SumWords::kIrradiance), "accepted");
  EXPECT_EQ(amount(-1, wire::SumWords::kIrradiance), "ray 0: opacity: expected an amount of 0..2^23 - 1, got 16777215");
  EXPECT_EQ(amount(-((1 << 23) - 1), wire::SumWords::kWhole), "accepted");
  EXPECT_EQ(amount(-(1 << 23), wire::SumWords::kWhole),
            "ray 0: opacity: expected an amount of at least -(2^23 - 1), got 8388608");
}

// 24 bits of whole units and 12 of fractions, instead of 8.
TEST(TraceCommand, TakesMoreEnergyOnTheWideDatapath) {
  v1::BoardConfig config = blocks_of_eight();
  config.mutable_asic()->set_datapath(v1::wide);
  BareBoard board(config);
  load_fog(board, 1000);
  const auto energy = [&board](std::uint64_t word) {
    wire::Ray light = host_ray(0, {1, 1, 1}, {0, 0, 1});
    light.flags |= wire::kLightingRay;
    light.set_colour_word(word);
    return refusal(board, BareBoard::trace_payload({light}, {.type = wire::RayType::kDeposit}));
  };
  EXPECT_EQ(energy(1044481), "accepted");
  EXPECT_EQ(energy(68'719'472'640), "accepted");
  EXPECT_EQ(energy(68'719'472'641), "ray 0: energy: expected 1..68719472640 (24.12), got 68719472641");
}

// Ten samples of 100 units each.
TEST(TraceCommand, OfABackprojectionSaysWhatItLeft) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 1000);
    wire::Ray ray = host_ray(0, {1, 8, 8}, {1, 0, 0});
    ray.set_colour_word(10 << 16);
    ray.opacity = static_cast<std::uint32_t>(-100) & wire::kOpacityOne;
    const auto sums = carry_out(board, BareBoard::trace_payload({ray, ray}, {.type = wire::RayType::kBackproject,
                                                                             .words = wire::SumWords::kWhole}));
    auto ledger = wire::decode<wire::DepositLedger>(std::span(sums.payload));
    EXPECT_EQ(ledger.rays, 2u);
    EXPECT_EQ(ledger.samples, 20u);
    EXPECT_EQ(ledger.kept, -2000);
    EXPECT_EQ(ledger.clipped, 0);
    EXPECT_EQ(ledger.overflowed, 0u);
    ray.opacity = 100 << wire::kAmountFractionBits;
    for (const std::int64_t kept : {1000, 1000}) {
      const auto words = carry_out(board, BareBoard::trace_payload({ray}, {.type = wire::RayType::kBackproject}));
      ledger = wire::decode<wire::DepositLedger>(std::span(words.payload));
      EXPECT_EQ(ledger.kept, kept);
    }
    EXPECT_EQ(board.counter("dsp.host_rays"), 4u);
    EXPECT_EQ(board.counter("pipeline.visible_samples"), 40u);
    EXPECT_EQ(board.counter("pipeline.deposits"), 40u);
    EXPECT_EQ(board.counter("dsp.lighting_rays"), 0u);
    EXPECT_EQ(board.counter("dsp.host_traps"), 0u);
    EXPECT_EQ(board.counter("pipeline.scatterings"), 0u);
  }
}

TEST(RenderCommand, ShowsTheTableThatWasWrittenLast) {
  for (const v1::Datapath datapath : {v1::paper, v1::wide}) {
    v1::BoardConfig config = blocks_of_eight();
    config.mutable_asic()->set_datapath(datapath);
    BareBoard board(config);
    load_fog(board, 100);
    const auto thin = board.render(corner_view({17, 17, 17}, 8));
    board.write_segmentation([](unsigned, unsigned) { return wire::SegmentationEntry{{2048, 2048, 2048}, 60'000}; });
    const auto dense = board.render(corner_view({17, 17, 17}, 8));
    EXPECT_GT(dense[36].alpha, 4000);
    EXPECT_LT(thin[36].alpha, 400);
  }
}

TEST(RenderCommand, RefusesWhatIsBeyondItsFields) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  const auto refused = [&board](const auto& spoil) {
    wire::RenderCommand view = corner_view({17, 17, 17}, 8);
    spoil(view);
    return refusal(board, wire::encoded(view));
  };
  using View = wire::RenderCommand;
  EXPECT_EQ(refused([](View&) {}), "accepted");
  EXPECT_EQ(refused([](View& view) { view.width = 0; }), "width: expected 1..4095, got 0");
  EXPECT_EQ(refused([](View& view) { view.height = 0; }), "height: expected 1..4095, got 0");
  EXPECT_EQ(refused([](View& view) { view.width = 1, view.height = 1; }), "accepted");
  EXPECT_EQ(refused([](View& view) { view.width = 4096; }), "width: expected 1..4095, got 4096");
  EXPECT_EQ(refused([](View& view) { view.height = 4096; }), "height: expected 1..4095, got 4096");
  EXPECT_EQ(refused([](View& view) { view.projection = static_cast<wire::Projection>(2); }),
            "projection: expected 0 or 1, got 2");
  EXPECT_EQ(refused([](View& view) { view.samples_per_axis = 3; }), "samples_per_axis: expected 1, 2 or 4, got 3");
  EXPECT_EQ(refused([](View& view) { view.filter = static_cast<wire::Filter>(2); }), "filter: expected 0 or 1, got 2");
  EXPECT_EQ(refused([](View& view) { view.dv[2] = HUGE_VAL; }), "origin, forward, du, dv: expected finite numbers");
  std::vector<std::uint8_t> cut = wire::encoded(corner_view({17, 17, 17}, 8));
  cut.pop_back();
  EXPECT_EQ(refusal(board, cut), "payload: expected 112 bytes, got 111");
}

TEST(Materials, AreCheckedByEveryCommandWhoseRaysMeetThem) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  const auto refused = [&board](const wire::Material& material) {
    board.write_memory(wire::kMaterials.base + 2 * wire::kMaterialBytes, wire::encoded(material));
    return refusal(board, wire::encoded(corner_view({17, 17, 17}, 8)));
  };
  EXPECT_EQ(refused({.bsdf = static_cast<wire::Bsdf>(7)}), "material 2: bsdf: expected 0..6, got 7");
  EXPECT_EQ(refused({.parameter_count = 33}), "material 2: parameters: expected at most 32, got 33");
  EXPECT_EQ(refused({.parameter_count = 32}), "accepted");
  EXPECT_EQ(refused({.bsdf = wire::Bsdf::kTrap, .routine = 77}),
            "material 2: routine: expected the number of a routine that the board has, got 77");
}

wire::IlluminateCommand sunlight(double energy) {
  wire::IlluminateCommand command;
  command.kind = wire::LightKind::kDirectional;
  command.energy = energy;
  command.u = {0, 0, 1};
  return command;
}

TEST(IlluminateCommand, HasItsLengthAndAValidLight) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  std::vector<std::uint8_t> payload = wire::encoded(sunlight(100));
  EXPECT_EQ(refusal(board, payload), "accepted");
  payload.push_back(0);
  EXPECT_EQ(refusal(board, payload), "payload: expected 104 bytes, got 105");
  wire::IlluminateCommand dark = sunlight(100);
  dark.count = 0;
  EXPECT_EQ(refusal(board, wire::encoded(dark)), "count must be at least 1");
}

// 16 x 16 face cells under a light along z, none of whose rays meets anything.
TEST(IlluminateCommand, CountsItsRaysInClearAirToo) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 0);
    const Completion done = carry_out(board, wire::encoded(sunlight(100)));
    const auto ledger = wire::decode<wire::LightingLedger>(std::span(done.payload));
    EXPECT_EQ(ledger.rays, 256u);
    EXPECT_EQ(ledger.escaped, ledger.emitted);
    EXPECT_EQ(ledger.emitted, 25'600u);
    EXPECT_EQ(board.counter("dsp.lighting_rays"), 256u);
    EXPECT_EQ(board.counter("pipeline.deposits"), 0u);
    EXPECT_EQ(board.counter("pipeline.scatterings"), 0u);
  }
}

TEST(IlluminateCommand, SaysWhetherItsLightStandsInASolid) {
  BareBoard board(blocks_of_eight());
  board.load_volume({17, 17, 17}, [](int x, int y, int) {
    return wire::Voxel{static_cast<std::uint16_t>(x >= 8 && y < 8 ? 2000 : 0), 0, 0, 0};
  });
  board.write_segmentation([](unsigned, unsigned density) {
    return wire::SegmentationEntry{{1, 1, 1}, static_cast<std::uint16_t>(density > 1000 ? 65535 : 0)};
  });
  const auto in_solid = [&board](wire::LightKind kind, const Vector& position, const Vector& u, const Vector& v) {
    wire::IlluminateCommand command;
    command.kind = kind;
    command.energy = 1000;
    command.position = position;
    command.u = u;
    command.v = v;
    command.rays_per_voxel = command.count = 1;
    std::vector<std::uint8_t> payload(wire::kIlluminateCommandBytes);
    wire::encode(command, payload);
    const Completion done = carry_out(board, payload);
    EXPECT_EQ(done.error, wire::ErrorCode::kNone);
    return done.payload.at(56) != 0;  // after seven counts
  };
  EXPECT_TRUE(in_solid(wire::LightKind::kPoint, {12, 3, 8}, {}, {}));
  EXPECT_FALSE(in_solid(wire::LightKind::kPoint, {3, 3, 8}, {}, {}));
  // The rectangle's centre counts: (12, 3), of a corner at (4, 2).
  EXPECT_TRUE(in_solid(wire::LightKind::kRectangle, {4, 2, 8}, {16, 0, 0}, {0, 2, 0}));
  EXPECT_FALSE(in_solid(wire::LightKind::kRectangle, {12, 3, 8}, {0, 4, 0}, {0, 8, 1}));
  EXPECT_FALSE(in_solid(wire::LightKind::kPoint, {12, 3, 99}, {}, {}));
}

std::vector<std::uint8_t> pairs_payload(const wire::PairsHeader& header, const std::vector<wire::Element>& elements,
                                        const std::vector<wire::Pair>& pairs) {
  std::vector<std::uint8_t> bytes = wire::encoded(header);
  for (const wire::Element& element : elements) wire::append(bytes, element);
  for (const wire::Pair& pair : pairs) wire::append(bytes, pair);
  return bytes;
}

const wire::Element kFloor{wire::ElementKind::kPatch, {6, 6, 2}, {1, 0, 0}, {0, 1, 0}, {}};
const wire::Element kCeiling{wire::ElementKind::kPatch, {6, 6, 12}, {0, 1, 0}, {1, 0, 0}, {}};

// Two unit squares ten apart: 1 / (100 pi) within a percent; all arrives, or what one opacity of ten voxels leaves.
TEST(PairsCommand, SumsUpItsRaysAtBothLevelsToTheSameBits) {
  std::vector<std::uint8_t> functional;
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 6553);  // a tenth a voxel
    const wire::PairsHeader header{.elements = 2, .pairs = 2, .rays = 32, .first = 0, .seed = 3};
    const auto payload = pairs_payload(header, {kFloor, kCeiling}, {{0, 1, 7}, {1, 1, 8}});
    const Completion done = carry_out(board, payload);
    ASSERT_EQ(done.error, wire::ErrorCode::kNone);
    ASSERT_EQ(done.payload.size(), 32u);
    const auto pair = wire::decode<wire::PairResult>(std::span(done.payload));
    EXPECT_NEAR(pair.geometric, 1 / (100 * 3.14159265), 0.03e-3);
    EXPECT_NEAR(pair.transported / pair.geometric, std::pow(0.9, 10), 0.01);
    EXPECT_EQ(wire::decode<wire::PairResult>(std::span(done.payload).subspan(16)).geometric, 0) << "with itself";
    if (level == v1::functional) functional = done.payload;
    EXPECT_EQ(done.payload, functional);
    EXPECT_EQ(board.counter("dsp.pair_rays"), 64u);
  }
}

TEST(PairsCommand, CountsPhysicalLengths) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  for (const std::uint32_t axis : {reg::kSpacingX, reg::kSpacingY, reg::kSpacingZ})
    board.write_register(axis, 2 * wire::kSpacingOne);
  const auto payload = pairs_payload({.elements = 2, .pairs = 1, .rays = 32}, {kFloor, kCeiling}, {{0, 1, 7}});
  const Completion done = carry_out(board, payload);
  const auto pair = wire::decode<wire::PairResult>(std::span(done.payload));
  EXPECT_NEAR(pair.geometric, 1 / (400 * 3.14159265), 0.01e-3);
  EXPECT_NEAR(pair.transported, pair.geometric, 1e-6);
}

// The board's samples are those of the wire's definition, from `first` on; in clear air nothing is lost.
TEST(PairsCommand, TakesItsSamplesFromTheFirstOnBySeedAndId) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 0);
    const wire::PairsHeader header{.elements = 2, .pairs = 1, .rays = 16, .first = 5, .seed = 1003};
    const Completion done = carry_out(board, pairs_payload(header, {kFloor, kCeiling}, {{0, 1, 7}}));
    const auto pair = wire::decode<wire::PairResult>(std::span(done.payload));
    wire::PairSum expected(16);
    for (std::uint32_t i = 0; i < 16; ++i) {
      const auto sample = wire::pair_sample(kFloor, kCeiling, {{{0, 0, 1}, {0, 0, -1}}}, {1, 1, 1}, 7, 1003, 5 + i);
      expected.add(i, sample.weight, 1);
    }
    EXPECT_EQ(pair, expected.result());
  }
}

// However many there are, threads take whole batches of them (2,048 rays) and what is left.
TEST(PairsCommand, GivesEachOfManyPairsItsOwnResult) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  for (const std::uint32_t count : {1u, 63u, 64u, 65u, 129u}) {
    std::vector<wire::Pair> pairs;
    for (std::uint32_t id = 0; id < count; ++id) pairs.push_back({0, 1, id});
    const wire::PairsHeader header{.elements = 2, .pairs = count, .rays = 32};
    const Completion done = carry_out(board, pairs_payload(header, {kFloor, kCeiling}, pairs));
    ASSERT_EQ(done.error, wire::ErrorCode::kNone) << count;
    ASSERT_EQ(done.payload.size(), count * wire::kPairResultBytes);
    for (const std::uint32_t id : {0u, count - 1}) {
      wire::PairSum expected(32);
      for (std::uint32_t i = 0; i < 32; ++i) {
        const auto sample = wire::pair_sample(kFloor, kCeiling, {{{0, 0, 1}, {0, 0, -1}}}, {1, 1, 1}, id, 0, i);
        expected.add(i, sample.weight, 1);
      }
      const auto got = std::span(done.payload).subspan(id * wire::kPairResultBytes);
      EXPECT_EQ(wire::decode<wire::PairResult>(got), expected.result()) << id << " of " << count;
    }
  }
}

// The DSP holds 65,536 rays, 2,048 pairs of 32. All but the last of 2,050 pairs look away from each other and send none.
TEST(PairsCommand, OfMoreRaysThanTheDspHoldsGiveEachPairItsOwnResult) {
  BareBoard board(blocks_of_eight(v1::cycle));
  load_fog(board, 0);
  std::vector<wire::Pair> pairs(2049, {0, 2, 1});
  pairs.push_back({0, 1, 7});
  wire::Element away = kCeiling;
  std::swap(away.u, away.v);
  const wire::PairsHeader header{.elements = 3, .pairs = 2050, .rays = 32};
  const Completion done = carry_out(board, pairs_payload(header, {kFloor, kCeiling, away}, pairs));
  ASSERT_EQ(done.payload.size(), 2050 * wire::kPairResultBytes);
  for (std::size_t pair = 0; pair < 2049; ++pair) {
    const auto result = wire::decode<wire::PairResult>(std::span(done.payload).subspan(pair * wire::kPairResultBytes));
    ASSERT_EQ(result.transported, 0) << pair;
  }
  const auto last = wire::decode<wire::PairResult>(std::span(done.payload).subspan(2049 * wire::kPairResultBytes));
  EXPECT_NEAR(last.transported, 1 / (100 * 3.14159265), 0.03e-3);
}

TEST(PairsCommand, RefusesWhatIsBeyondItsFields) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  const auto refused = [&board](wire::PairsHeader header, const wire::Element& element = kCeiling,
                                wire::Pair pair = {0, 1, 7}) {
    header.elements = 2;
    header.pairs = 1;
    return refusal(board, pairs_payload(header, {kFloor, element}, {pair}));
  };
  EXPECT_EQ(refused({.rays = 1}), "accepted");
  EXPECT_EQ(refused({.rays = 0}), "rays: expected 1..65536, got 0");
  EXPECT_EQ(refused({.rays = 65537}), "rays: expected 1..65536, got 65537");
  EXPECT_EQ(refused({.rays = 4, .first = 0xFFFF'FFFF - 4}), "accepted");
  EXPECT_EQ(refused({.rays = 4, .first = 0xFFFF'FFFF - 3}), "first: expected below 2^32 - rays, got 4294967292");
  EXPECT_EQ(refused({.rays = 4, .opacity = 0}), "opacity: expected 1..2^24 - 1, got 0");
  EXPECT_EQ(refused({.rays = 4, .opacity = 1}), "accepted");
  EXPECT_EQ(refused({.rays = 4, .opacity = 1 << 24}), "opacity: expected 1..2^24 - 1, got 16777216");
  wire::Element outside = kCeiling;
  outside.origin[2] = 16.5F;
  EXPECT_EQ(refused({.rays = 4}, outside), "element 1: origin, u, v, w: expected an element in the volume");
  outside.origin[2] = 16;
  EXPECT_EQ(refused({.rays = 4}, outside), "accepted");
  EXPECT_EQ(refused({.rays = 4}, kCeiling, {0, 2, 7}), "pair 0: a, b: expected elements below 2, got 2");
  EXPECT_EQ(refusal(board, {6, 0, 0, 0}), "payload: expected at least 32 bytes, got 4");
}

// Centres of pixels, or of their quarters, in an image of one tile of 16 pixels and in one of four.
void expect_rays_in_the_middle(int pixels) {
  wire::RenderCommand view = corner_view({17, 17, 17}, pixels);
  Frame frame;
  frame.extent = {16 << 14, 16 << 14, 16 << 14};
  const v1::DspConfig dsp;
  for (const auto& [samples, first, step] : {std::array{1, 8, 16}, {2, 4, 8}, {4, 2, 4}}) {
    view.samples_per_axis = static_cast<std::uint8_t>(samples);
    Framebuffer framebuffer;
    framebuffer.clear(pixels, pixels, wire::Filter::kBox);
    ImageRays rays(view, frame, framebuffer, dsp);
    ASSERT_EQ(rays.count(), static_cast<std::uint64_t>(pixels * pixels * samples * samples));
    RayCounters counters;
    const int across = pixels * samples;
    int seen = 0;
    for (int i = 0; i < across * across; ++i) {
      const auto ray = rays.make(static_cast<std::uint64_t>(i), counters);
      if (!ray) continue;
      ++seen;
      EXPECT_EQ(ray->u, first + i % across * step);
      EXPECT_EQ(ray->v, first + i / across * step);
    }
    EXPECT_GT(seen, 0);
    std::size_t in_batches = 0;
    for (std::size_t b = 0; b < rays.divide(1000); ++b) {
      const auto batch = rays.make_batch(b);
      for (const wire::Ray& ray : batch->rays) {
        EXPECT_EQ((ray.u - first) % step, 0);
        EXPECT_EQ((ray.v - first) % step, 0);
        ++in_batches;
      }
    }
    EXPECT_EQ(in_batches, static_cast<std::size_t>(seen));
  }
}

TEST(ImageRays, LieInTheMiddleOfTheirPlaceInThePixel) {
  expect_rays_in_the_middle(4);
  expect_rays_in_the_middle(20);
}

TEST(LightingRays, StartAtTheNearestWordsAndRunAlongTheNearestDirection) {
  const Point extent{16 << 14, 16 << 14, 16 << 14};
  wire::IlluminateCommand command;
  command.kind = wire::LightKind::kDirectional;
  command.energy = 200;
  command.u = {1, 2, 3};
  command.rays_per_voxel = command.count = 1;
  const LightingRays sun(command, extent, {65536, 65536, 65536}, 8, 1);
  int rays = 0;
  for (std::uint64_t i = 0; i < sun.count(); ++i) {
    const auto ray = sun.make(i);
    if (!ray) continue;
    ++rays;
    EXPECT_EQ(ray->direction, (std::array<std::int16_t, 3>{-4379, -8758, -13136}));
  }
  EXPECT_GT(rays, 500);
  command.kind = wire::LightKind::kPoint;
  command.position = {3 + 0.7 / 16384, 4 + 0.2 / 16384, 5 + 0.5 / 16384};
  command.energy = 40'000;
  const LightingRays lamp(command, extent, {65536, 65536, 65536}, 8, 1);
  for (std::uint64_t i = 0; i < lamp.count(); ++i) {
    const auto ray = lamp.make(i);
    if (ray) {
      ASSERT_EQ(ray->position, (std::array<std::uint32_t, 3>{(3u << 14) + 1, 4u << 14, (5u << 14) + 1}));
    }
  }
}

TEST(Vectors, TurnAboutTheAxisFromXToY) {
  const auto near = [](const Vector& got, const Vector& expected) {
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(got[axis], expected[axis], 1e-12);
  };
  near(around({0, 0, 1}, 1, 0.3), {0, 0, 1});
  near(around({0, 0, 1}, 0, 0), {1, 0, 0});
  near(around({0, 0, 1}, 0, 0.25), {0, 1, 0});
  near(around({0, 0, 1}, -0.6, 0.5), {-0.8, 0, -0.6});
}

}  // namespace
}  // namespace gicube::emu
