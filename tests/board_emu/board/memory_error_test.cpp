// RDRAM bit errors, and the command that reads the volume's blocks back.
#include "bare_board.h"
#include "gicube/wire/checksum.h"
#include "test.h"

namespace gicube::emu {
namespace {

using wire::ErrorCode;
namespace reg = wire::reg;

constexpr std::array<int, 3> kSize{20, 20, 20};  // 3 x 3 x 3 blocks of 8
constexpr std::size_t kBlockBytes = 512 * 36 / 8;

v1::BoardConfig config(v1::FidelityLevel fidelity = v1::functional) {
  v1::BoardConfig config;
  config.set_fidelity(fidelity);
  config.set_threads(1);
  config.mutable_asic()->set_block_voxels(8);
  config.mutable_asic()->set_max_volume_voxels(32);
  return config;
}

// Every block is written, every voxel shows.
void load(BareBoard& board) {
  board.load_volume(kSize, [](int x, int y, int z) {
    return wire::Voxel{static_cast<std::uint16_t>(100 + 7 * x + 31 * y + 57 * z), 0, 0, 0};
  });
  board.write_segmentation([](unsigned, unsigned density) {
    return wire::SegmentationEntry{{static_cast<std::uint16_t>(density), 2048, 1024},
                                   static_cast<std::uint16_t>(density)};
  });
}

std::vector<std::uint8_t> verify_command(std::uint32_t first, std::uint32_t count) {
  std::vector<std::uint8_t> payload(wire::kVerifyCommandBytes);
  wire::store(std::span(payload), 0, static_cast<std::uint32_t>(wire::Opcode::kVerify));
  wire::store(std::span(payload), 4, first);
  wire::store(std::span(payload), 8, count);
  return payload;
}

std::vector<std::uint32_t> verify(BareBoard& board, std::uint32_t first = 0, std::uint32_t count = 27) {
  const Completion completion = board.wait(board.command(verify_command(first, count))).completions.at(0);
  EXPECT_EQ(completion.error, ErrorCode::kNone);
  std::vector<std::uint32_t> sums;
  for (std::size_t at = 0; at < completion.payload.size(); at += 4) {
    sums.push_back(wire::load<std::uint32_t>(completion.payload, at));
  }
  return sums;
}

std::string refusal(BareBoard& board, std::uint32_t first, std::uint32_t count) {
  const Completion completion = board.wait(board.command(verify_command(first, count))).completions.at(0);
  EXPECT_EQ(completion.error, ErrorCode::kBadValue);
  return {completion.payload.begin(), completion.payload.end()};
}

TEST(MemoryError, ADetectedOneFailsTheNextCommandAlone) {
  BareBoard board(config());
  load(board);
  const auto view = corner_view(kSize, 16);
  const auto expected = board.render(view);
  board.add_memory_error({5, 37, true});
  EXPECT_EQ(board.read_register(reg::kId), wire::kIdValue);
  const std::vector<wire::Ray> rays{host_ray(1, {1, 1, 1}, {1, 0, 0})};
  const Completion failed = board.wait(board.command(BareBoard::trace_payload(rays))).completions.at(0);
  EXPECT_EQ(failed.error, ErrorCode::kMemory);
  EXPECT_EQ(std::string(failed.payload.begin(), failed.payload.end()),
            "the RDRAM reported an error that it could not correct: block 5, word 1");
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusMemory);
  EXPECT_EQ(board.trace(rays).size(), 1u);
  EXPECT_EQ(board.render(view), expected);
}

TEST(MemoryError, EachDetectedOneFailsACommandOfItsOwn) {
  BareBoard board(config());
  load(board);
  board.add_memory_error({0, 0, true});
  board.add_memory_error({0, 0, true});
  const auto error = [&] { return board.wait(board.command(verify_command(0, 1))).completions.at(0).error; };
  EXPECT_EQ(error(), ErrorCode::kMemory);
  EXPECT_EQ(error(), ErrorCode::kMemory);
  EXPECT_EQ(error(), ErrorCode::kNone);
}

TEST(MemoryError, ASilentOneIsWrongAtEveryFidelityLevelUntilItsBlockIsWritten) {
  for (const v1::FidelityLevel fidelity : {v1::functional, v1::cycle}) {
    BareBoard board(config(fidelity));
    load(board);
    const auto view = corner_view(kSize, 16);
    const auto expected = board.render(view);
    const auto sums = verify(board);
    const std::vector<std::uint8_t> block =
        board.read_memory(wire::kVolume.base + 13 * kBlockBytes, kBlockBytes).payload;
    // The highest density bit of a voxel in the middle of the volume.
    board.add_memory_error({13, 36 * 200 + 11, false});
    EXPECT_NE(board.render(view), expected) << fidelity;
    auto damaged = verify(board);
    EXPECT_NE(damaged[13], sums[13]);
    damaged[13] = sums[13];
    EXPECT_EQ(damaged, sums);
    board.write_memory(wire::kVolume.base + 13 * kBlockBytes, block);
    EXPECT_EQ(board.render(view), expected) << fidelity;
    EXPECT_EQ(verify(board), sums);
  }
}

TEST(MemoryError, ASilentOneOnAFaceIsSeenByTheBlockBeforeIt) {
  BareBoard board(config());
  load(board);
  // Its one sample lies in block 12, between its own last voxels and the face that it shares with block 13.
  const std::vector<wire::Ray> rays{host_ray(1, {7.25, 12, 12}, {1, 0, 0})};
  board.write_register(reg::kStep, wire::kStepOne / 4);
  board.write_register(reg::kOpacityThreshold, 1);
  const auto expected = board.trace(rays);
  const std::uint32_t voxel = (4 * 8 + 4) * 8;  // (8, 12, 12)
  board.add_memory_error({13, 36 * voxel + 11, false});
  EXPECT_NE(board.trace(rays), expected);
}

TEST(MemoryError, BlockAndBitCountRoundOverWhatIsStored) {
  BareBoard board(config());
  for (std::uint32_t axis = 0; axis < 3; ++axis) board.write_register(reg::kVolumeX + 4 * axis, 20);
  board.add_memory_error({3, 3, false});  // nothing is stored
  std::vector<std::uint8_t> block(kBlockBytes, 0x11);
  for (const unsigned b : {4u, 9u}) board.write_memory(wire::kVolume.base + b * kBlockBytes, block);
  board.add_memory_error({3, 8 * kBlockBytes * 2 + 9, false});
  EXPECT_EQ(board.read_memory(wire::kVolume.base + 4 * kBlockBytes, kBlockBytes).payload, block);
  block[1] = 0x13;
  EXPECT_EQ(board.read_memory(wire::kVolume.base + 9 * kBlockBytes, kBlockBytes).payload, block);
}

TEST(MemoryError, AResetForgetsThem) {
  BareBoard board(config());
  board.add_memory_error({0, 0, true});
  board.write_register(reg::kControl, wire::kControlReset);
  load(board);
  EXPECT_EQ(verify(board).size(), 27u);
}

TEST(Verify, SumsUpTheWordsOfEachBlockAsTheyAreRead) {
  BareBoard board(config());
  load(board);
  const auto sums = verify(board, 3, 20);
  ASSERT_EQ(sums.size(), 20u);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto words = board.read_memory(wire::kVolume.base + (3 + i) * kBlockBytes, kBlockBytes).payload;
    EXPECT_EQ(sums[i], wire::crc32c(words));
  }
}

TEST(Verify, ABlockThatWasNeverWrittenIsZero) {
  BareBoard board(config());
  for (std::uint32_t axis = 0; axis < 3; ++axis) board.write_register(reg::kVolumeX + 4 * axis, 20);
  EXPECT_EQ(verify(board, 0, 1).at(0), wire::crc32c(std::vector<std::uint8_t>(kBlockBytes)));
}

TEST(Verify, TakesTheTimeThatTheFullestChannelNeedsForItsPackets) {
  for (const v1::FidelityLevel fidelity : {v1::functional, v1::cycle}) {
    for (const unsigned sharing : {1u, 2u}) {
      v1::BoardConfig shared = config(fidelity);
      shared.mutable_rdram()->set_processors_per_rdram(sharing);
      BareBoard board(shared);
      load(board);
      board.read_register(reg::kId);  // all has been written
      const std::uint64_t nothing = [&] {
        const std::uint64_t begin = board.now_ps;
        EXPECT_EQ(board.wait(board.command(verify_command(0, 0))).completions.at(0).error, ErrorCode::kBadValue);
        return board.now_ps - begin;
      }();
      const std::uint64_t begin = board.now_ps;
      verify(board);
      // Slabs one block thick: of the four processors the first three have 9 blocks each, of 512 / 4 packets, 10 ns
      // each.
      const std::uint64_t reading = 9 * sharing * 128 * 10'000;
      EXPECT_GE(board.now_ps - begin, reading) << sharing;
      // The transfers beside it: 27 words up instead of one.
      EXPECT_LE(board.now_ps - begin, reading + nothing + 27 * 30'000) << sharing;
    }
  }
}

TEST(Verify, RefusesWhatIsNotThere) {
  BareBoard board(config());
  EXPECT_NE(refusal(board, 0, 1).find("no volume"), std::string::npos);
  load(board);
  EXPECT_EQ(refusal(board, 0, 0), "count: expected 1..65536, got 0");
  EXPECT_EQ(refusal(board, 0, 65537), "count: expected 1..65536, got 65537");
  EXPECT_EQ(refusal(board, 20, 8), "first + count: expected at most 27 blocks, got 28");
  EXPECT_EQ(refusal(board, 0xFFFFFFFF, 2), "first + count: expected at most 27 blocks, got 4294967297");
  EXPECT_EQ(refusal(board, 26, 2), "first + count: expected at most 27 blocks, got 28");
}

}  // namespace
}  // namespace gicube::emu
