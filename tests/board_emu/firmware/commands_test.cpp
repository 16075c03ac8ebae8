// The DSP's commands through the board's connector: what each field may hold, what counts and what comes back, worked
// by hand.
#include "commands_rig.h"
#include "test.h"
#include "words/vectors.h"

namespace gicube::emu {
namespace {

namespace reg = wire::reg;

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
                         {reg::kPipeline, 0, 127},
                         {reg::kLifetime, 0, 1023},
                         {reg::kCutPlanes, 0, 6},
                         {reg::kVolumeX, 2, 1024}}) {
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

// Also where a tent takes rays from the rows beside a strip, and where the last strip is cut short.
TEST(RenderCommand, MakesThePartsThatTogetherAreTheWholePicture) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 300);
  for (const auto& [samples, filter, strip, parts] : {std::tuple{1, wire::Filter::kBox, 1, 3},
                                                      {2, wire::Filter::kBox, 2, 2},
                                                      {1, wire::Filter::kTent, 1, 4},
                                                      {2, wire::Filter::kTent, 1, 3},
                                                      {4, wire::Filter::kTent, 3, 2},
                                                      {2, wire::Filter::kTent, 10, 1}}) {
    wire::RenderCommand view = corner_view({17, 17, 17}, 10);
    view.samples_per_axis = static_cast<std::uint8_t>(samples);
    view.filter = filter;
    const auto whole = board.render(view);
    view.strip_rows = static_cast<std::uint16_t>(strip);
    view.parts = static_cast<std::uint8_t>(parts);
    int rows = 0;
    for (view.part = 0; view.part < view.parts; ++view.part) {
      const auto part = board.render(view);
      int here = 0;
      for (int y = 0; y < 10; ++y) {
        if (y / strip % parts != view.part) continue;
        for (std::size_t x = 0; x < 10; ++x) {
          ASSERT_EQ(part[static_cast<std::size_t>(here) * 10 + x], whole[static_cast<std::size_t>(y) * 10 + x])
              << samples << ' ' << strip << ' ' << parts << ", row " << y;
        }
        ++here;
      }
      EXPECT_EQ(part.size(), static_cast<std::size_t>(here) * 10);
      rows += here;
    }
    EXPECT_EQ(rows, 10);
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
  const auto part = [&refused](int strip_rows, int number, int parts) {
    return refused([&](View& view) {
      view.strip_rows = static_cast<std::uint16_t>(strip_rows);
      view.part = static_cast<std::uint8_t>(number);
      view.parts = static_cast<std::uint8_t>(parts);
    });
  };
  EXPECT_EQ(part(1, 0, 1), "accepted");
  EXPECT_EQ(part(2, 3, 4), "accepted");
  EXPECT_EQ(part(8, 0, 255), "accepted");
  EXPECT_EQ(part(0, 0, 2), "strip_rows: expected 1..height, got 0");
  EXPECT_EQ(part(9, 0, 2), "strip_rows: expected 1..height, got 9");
  EXPECT_EQ(part(1, 2, 2), "part: expected less than parts, got 2");
  EXPECT_EQ(part(2, 4, 5), "accepted") << "a part without rows";
  EXPECT_EQ(part(1, 0, 0), "part, strip_rows: expected 0 of a whole picture, got 0");
  std::vector<std::uint8_t> cut = wire::encoded(corner_view({17, 17, 17}, 8));
  cut.pop_back();
  EXPECT_EQ(refusal(board, cut), "payload: expected at least 112 bytes, got 111");
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

TEST(IlluminateCommand, HasItsLengthAndAValidLight) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  std::vector<std::uint8_t> payload = wire::encoded(sunlight(100));
  EXPECT_EQ(refusal(board, payload), "accepted");
  payload.push_back(0);
  EXPECT_EQ(refusal(board, payload), "payload: expected 104 bytes, got 105");
  wire::IlluminateCommand dark = sunlight(100);
  dark.count = 0;
  EXPECT_EQ(refusal(board, wire::encoded(dark)), "count: expected at least 1, got 0");
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

// A host may leave PIPELINE as pictures need it.
TEST(IlluminateCommand, ChangesPicturesThatAreLitByIrradianceAlsoWhilePipelineAsksForThem) {
  const auto lit_twice = [](bool stays) {
    BareBoard board(blocks_of_eight());
    load_fog(board, 3000);
    std::vector<std::vector<wire::Pixel>> pictures;
    for (int i = 0; i < 2; ++i) {
      if (!stays) board.write_register(wire::reg::kPipeline, 0);
      EXPECT_EQ(refusal(board, wire::encoded(sunlight(200))), "accepted");
      board.write_register(wire::reg::kPipeline, wire::kPipelineIrradiance);
      pictures.push_back(board.render(corner_view({17, 17, 17}, 8)));
    }
    return pictures;
  };
  const auto pictures = lit_twice(true);
  EXPECT_EQ(pictures, lit_twice(false));
  EXPECT_NE(pictures[0], pictures[1]);
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
    const auto payload = wire::encoded(command);
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

}  // namespace
}  // namespace gicube::emu
