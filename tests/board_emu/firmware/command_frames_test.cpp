// What a command takes from registers, tables and memory, whether it is what stands there now, and what it counts of
// its rays.
#include "commands_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace reg = wire::reg;

TEST(Commands, OfAnUnknownOpcodeAreToldTheKnownOnes) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  EXPECT_EQ(refusal(board, {11, 0, 0, 0}),
            "opcode: expected 1 (render), 2 (trace), 3 (illuminate), 4 (resume), 5 (verify), 6 (pairs), 7 (continue), "
            "8 (take "
            "rays), 9 (give rays) or 10 (load coarse), got 11");
}

TEST(VerifyCommand, HasItsLength) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  std::vector<std::uint8_t> payload(15);
  payload[0] = 5;
  EXPECT_EQ(refusal(board, payload), "payload: expected 16 bytes, got 15");
}

TEST(ContinueCommand, HasItsLengthAndNeedsRaysThatWait) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  EXPECT_EQ(refusal(board, {7, 0, 0, 0}), "payload: expected 8 bytes, got 4");
  EXPECT_EQ(refusal(board, wire::encoded(wire::ContinueCommand{})), "no ray waits for a block");
}

TEST(AbsentBlocks, RefuseAllThatDoesNotWait) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 100);
  board.write_memory(wire::kAbsentFlags.base, std::vector<std::uint8_t>{2});
  const std::string refused = "absent_flags: expected none set for this command, got some";
  EXPECT_EQ(refusal(board, wire::encoded(sunlight(100))), refused);
  EXPECT_EQ(refusal(board, wire::encoded(wire::TraceHeader{})), refused);
  EXPECT_EQ(refusal(board, wire::encoded(wire::ResumeHeader{})), refused);
  wire::RenderCommand picture{.width = 4, .height = 4, .forward = {0, 0, 1}, .du = {0.1, 0, 0}, .dv = {0, 0.1, 0}};
  EXPECT_EQ(refusal(board, wire::encoded(picture)), "accepted");
  board.write_register(reg::kPipeline, wire::kPipelineScatter);
  EXPECT_EQ(refusal(board, wire::encoded(picture)), "accepted");
  wire::Material host{.bsdf = wire::Bsdf::kTrap, .routine = wire::kHostRoutine};
  board.write_memory(wire::kMaterials.base, wire::encoded(host));
  EXPECT_EQ(refusal(board, wire::encoded(picture)),
            "material 0: routine 255 (the host's): expected one of the board for a trace command, for light in three "
            "irradiance words, and while blocks are absent");
}

// 40^3 voxels in 125 blocks, on a card that stores 64.
TEST(Capacity, IsWhatTheCardStoresOfALargerVolume) {
  v1::BoardConfig config = blocks_of_eight();
  config.mutable_asic()->set_max_volume_voxels(32);
  BareBoard board(config);
  for (std::uint32_t axis = 0; axis < 3; ++axis) board.write_register(reg::kVolumeX + 4 * axis, 40);
  constexpr std::uint64_t kBlockBytes = 8 * 8 * 8 * 9 / 2;
  const std::vector<std::uint8_t> byte{1};
  for (std::uint64_t block = 60; block < 124; ++block) {
    board.write_memory(wire::kVolume.base + block * kBlockBytes, byte);
  }
  board.write_memory(wire::kVolume.base + 60 * kBlockBytes + 7, byte);  // of a block that it stores
  EXPECT_EQ(board.read_register(reg::kStatus), 0u);
  board.write_memory(wire::kVolume.base, byte);
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadAddress);
  board.write_register(reg::kStatusClear, wire::kStatusBadAddress);
  board.write_register(reg::kControl, wire::kControlDropBlocks);
  board.write_memory(wire::kVolume.base, byte);
  EXPECT_EQ(board.read_register(reg::kStatus), 0u);
  EXPECT_EQ(board.read_register(reg::kVolumeX), 40u);
}

wire::LightingLedger lit(BareBoard& board, const wire::IlluminateCommand& command) {
  const Completion done = carry_out(board, wire::encoded(command));
  EXPECT_EQ(done.error, wire::ErrorCode::kNone);
  return wire::decode<wire::LightingLedger>(std::span(done.payload));
}

// 256 rays of 100 units run away from the sun, through clear air.
TEST(IlluminateCommand, SaysThroughWhichFaceItsRaysEscape) {
  BareBoard board(blocks_of_eight());
  load_fog(board, 0);
  using Faces = std::array<std::uint64_t, wire::kFaces>;
  EXPECT_EQ(lit(board, sunlight(100)).escaped_by_face, (Faces{0, 0, 0, 0, 25'600, 0}));
  EXPECT_EQ(lit(board, sunlight(100, {-1, 0, 0})).escaped_by_face, (Faces{0, 25'600, 0, 0, 0, 0}));
}

// The upper half is dense: opaque at first, and then as clear as the lower one. Where the two meet, a sample's part of
// its ray takes its opacity from the table's depths.
TEST(IlluminateCommand, GoesByTheTableThatWasWrittenLast) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    board.load_volume({17, 17, 17}, [](int, int, int z) {
      return wire::Voxel{static_cast<std::uint16_t>(z < 8 ? 0 : 4000), 0, 0, 0};
    });
    board.write_segmentation([](unsigned, unsigned density) {
      return wire::SegmentationEntry{{1, 1, 1}, static_cast<std::uint16_t>(density < 1000 ? 0 : 65535)};
    });
    const wire::LightingLedger opaque = lit(board, sunlight(100));
    EXPECT_EQ(opaque.deposited, 25'600u);
    EXPECT_EQ(opaque.escaped, 0u);
    board.write_segmentation([](unsigned, unsigned) { return wire::SegmentationEntry{{1, 1, 1}, 0}; });
    const wire::LightingLedger clear = lit(board, sunlight(100));
    EXPECT_EQ(clear.deposited, 0u);
    EXPECT_EQ(clear.escaped, 25'600u);
  }
}

// A board that is reset counts its tables anew.
TEST(IlluminateCommand, GoesByTheTableThatWasWrittenAfterAReset) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    for (const int opacity : {65535, 0}) {
      board.load_volume({17, 17, 17}, [](int, int, int z) {
        return wire::Voxel{static_cast<std::uint16_t>(z < 8 ? 0 : 4000), 0, 0, 0};
      });
      board.write_segmentation([opacity](unsigned, unsigned density) {
        return wire::SegmentationEntry{{1, 1, 1}, static_cast<std::uint16_t>(density < 1000 ? 0 : opacity)};
      });
      EXPECT_EQ(lit(board, sunlight(100)).escaped, opacity == 0 ? 25'600u : 0u);
      board.write_register(wire::reg::kControl, wire::kControlReset);
    }
  }
}

// Rays along z have samples at 16, 15 ... 0. The conserving rules know no jitter, the printed ones do.
TEST(IlluminateCommand, TakesItsSamplesAStepApart) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 0);
    board.write_register(reg::kPipeline, wire::kPipelineJitter);
    lit(board, sunlight(100));
    EXPECT_EQ(board.counter("pipeline.samples"), 256u * 17);
    wire::IlluminateCommand printed = sunlight(100);
    printed.rules = wire::EnergyRules::kAsPrinted;
    lit(board, printed);
    EXPECT_NE(board.counter("pipeline.samples"), 2 * 256u * 17);
  }
}

// Opaque at their first sample. No light has been left in the volume: what it lights is black.
TEST(TraceCommand, LightsItsSegmentsByTheIrradiance) {
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    BareBoard board(blocks_of_eight(level));
    load_fog(board, 65535);
    wire::Ray way = host_ray(0, {1, 8, 8}, {1, 0, 0});
    way.set_colour_word(4 << 16);
    const auto seen = [&](std::uint32_t pipeline) {
      board.write_register(reg::kPipeline, pipeline);
      return board.trace({way}, {.type = wire::RayType::kSegment, .opacity = wire::kOpacityOne}).at(0);
    };
    const wire::Ray plain = seen(0), dark = seen(wire::kPipelineIrradiance);
    EXPECT_EQ(plain.colour, (std::array<std::uint16_t, 3>{2048, 2048, 2048}));
    EXPECT_EQ(dark.colour, (std::array<std::uint16_t, 3>{0, 0, 0}));
    EXPECT_EQ(dark.opacity, plain.opacity);
  }
}

// One block, which the cache holds whole.
TEST(VolumeCaches, KeepTheVolumeFromCommandToCommandUntilItIsWritten) {
  BareBoard board(blocks_of_eight(v1::cycle));
  board.load_volume({8, 8, 8}, [](int, int, int) { return wire::Voxel{1000, 0, 0, 0}; });
  std::uint64_t before = 0;
  const auto missed = [&board, &before] {
    board.trace({host_ray(0, {0, 3, 3}, {1, 0, 0})});
    const std::uint64_t now = board.counter("processor.cache.missed_voxels"), more = now - before;
    before = now;
    return more;
  };
  const std::uint64_t all = missed();
  EXPECT_GT(all, 0u);
  EXPECT_EQ(missed(), 0u);
  board.write_memory(wire::kVolume.base, std::vector<std::uint8_t>{0xE8});
  EXPECT_EQ(missed(), all);
  EXPECT_EQ(missed(), 0u);
}

}  // namespace
}  // namespace gicube::emu
