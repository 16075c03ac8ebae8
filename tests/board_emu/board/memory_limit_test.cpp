// What a board may take of the host's memory, and what it holds for a host that does not fetch it.
#include "bare_board.h"
#include "firmware/aperture.h"
#include "test.h"

namespace gicube::emu {
namespace {

using wire::ErrorCode;
using wire::FrameType;
namespace reg = wire::reg;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kBytesOfBlock = 32 * 32 * 32 * 9 / 2;

v1::BoardConfig board_of(std::uint32_t block_voxels, std::uint32_t max_volume_voxels) {
  v1::BoardConfig config;
  config.set_threads(1);
  config.mutable_asic()->set_block_voxels(block_voxels);
  config.mutable_asic()->set_max_volume_voxels(max_volume_voxels);
  return config;
}

BareBoard limited(std::uint64_t mib, const v1::BoardConfig& config = board_of(32, 128)) {
  return BareBoard(config, nullptr, nullptr, mib * kMiB);
}

void set_size(BareBoard& board, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  board.write_register(reg::kVolumeX, x);
  board.write_register(reg::kVolumeY, y);
  board.write_register(reg::kVolumeZ, z);
}

std::uint64_t address_of(std::uint64_t block) { return wire::kVolume.base + block * kBytesOfBlock; }

std::vector<std::uint8_t> render_of(const std::array<int, 3>& size, int image_size) {
  const auto payload = wire::encoded(corner_view(size, image_size));
  return payload;
}

std::vector<std::uint8_t> verify_of(std::uint32_t count) {
  std::vector<std::uint8_t> payload(wire::kVerifyCommandBytes);
  wire::store(std::span(payload), 0, static_cast<std::uint32_t>(wire::Opcode::kVerify));
  wire::store(std::span(payload), 8, count);
  return payload;
}

TEST(MemoryLimit, ABoardSaysWhatItMayTake) {
  EXPECT_EQ(limited(64).read_register(reg::kMaxMemory), 64u);
  EXPECT_EQ(BareBoard().read_register(reg::kMaxMemory), ~0u);
}

// A byte in a block takes a block, 144 KiB: 5 MiB hold 32 of them beside 389 KiB for all 64.
TEST(MemoryLimit, AWriteBeyondItIsRefusedAndLeavesWhatIsThere) {
  BareBoard board = limited(5);
  set_size(board, 128, 128, 128);
  const std::vector<std::uint8_t> byte{0xAB};
  std::uint64_t block = 0;
  while (board.read_register(reg::kStatus) == 0 && block < 64) board.write_memory(address_of(block++), byte);
  const std::uint64_t stored = block - 1;
  EXPECT_EQ(stored, 32u);
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadAddress | wire::kStatusNoMemory);
  EXPECT_EQ(board.read_register(reg::kErrorAddress), static_cast<std::uint32_t>(address_of(stored)));
  EXPECT_EQ(board.read_register(reg::kMemoryAsked), 6u);
  EXPECT_EQ(board.read_memory(address_of(stored), 1).payload, std::vector<std::uint8_t>{0});
  EXPECT_EQ(board.read_memory(address_of(stored - 1), 1).payload, byte);
  board.write_register(reg::kStatusClear, ~0u);
  board.write_memory(address_of(0) + 7, byte);  // of a block that is stored
  EXPECT_EQ(board.read_register(reg::kStatus), 0u);
}

TEST(MemoryLimit, ASizeWhoseBlocksAloneTakeMoreIsRefusedAndTheFormerVolumeStays) {
  BareBoard board = limited(64, board_of(8, 1024));
  set_size(board, 16, 16, 16);
  board.write_memory(wire::kVolume.base, std::vector<std::uint8_t>{0xCD});
  board.write_register(reg::kVolumeX, 1024);
  board.write_register(reg::kVolumeY, 1024);
  board.write_memory(wire::kVolume.base, std::vector<std::uint8_t>{0xCD});
  EXPECT_EQ(board.read_register(reg::kStatus), 0u);
  board.write_register(reg::kVolumeZ, 1024);
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadValue | wire::kStatusNoMemory);
  EXPECT_EQ(board.read_register(reg::kErrorAddress), reg::kVolumeZ);
  EXPECT_EQ(board.read_register(reg::kVolumeZ), 16u);
  EXPECT_GT(board.read_register(reg::kMemoryAsked), 64u);
  EXPECT_EQ(board.read_memory(wire::kVolume.base, 1).payload, std::vector<std::uint8_t>{0xCD});
}

TEST(MemoryLimit, ACommandThatNeedsMoreSaysSoAndASmallerOneIsCarriedOut) {
  const auto grey = [](int x, int, int) { return wire::Voxel{static_cast<std::uint16_t>(10 * x), 0, 0, 0}; };
  BareBoard board = limited(7);
  board.load_volume({96, 96, 96}, grey);  // 27 blocks: 4 MiB, while they are decoded 4 MiB more
  const Completion refused = board.wait(board.command(render_of({96, 96, 96}, 16))).completions.at(0);
  EXPECT_EQ(refused.error, ErrorCode::kBadValue);
  EXPECT_THAT(std::string(refused.payload.begin(), refused.payload.end()),
              AllOf(HasSubstr("memory: expected at most 7 MiB for volume, words and image"), HasSubstr("--max-memory"),
                    HasSubstr("got 8 MiB")));
  EXPECT_FALSE(board.read_memory(wire::kVolume.base, 9).payload.empty());

  BareBoard free(board_of(32, 128));
  for (BareBoard* each : {&board, &free}) each->load_volume({32, 32, 32}, grey);
  EXPECT_EQ(board.render(corner_view({32, 32, 32}, 16)), free.render(corner_view({32, 32, 32}, 16)));
}

TEST(MemoryLimit, AnImageCountsToo) {
  BareBoard board = limited(4);
  board.load_volume({32, 32, 32}, [](int, int, int) { return wire::Voxel{100, 0, 0, 0}; });
  const Completion refused = board.wait(board.command(render_of({32, 32, 32}, 400))).completions.at(0);
  EXPECT_EQ(refused.error, ErrorCode::kBadValue);
  EXPECT_EQ(board.render(corner_view({32, 32, 32}, 200)).size(), 200u * 200);
}

// 7 MiB hold 15 blocks beside 389 KiB for all 64, one block of 33^3 densities (2 bytes each), which those without words
// share, and for each of 160,000 pixels 24 bytes of sums and 36 bits.
TEST(MemoryLimit, AnImageCountsBesideWhatIsWrittenAfterIt) {
  BareBoard board = limited(7);
  set_size(board, 128, 128, 128);
  board.render(corner_view({128, 128, 128}, 400));
  std::uint64_t block = 0;
  while (board.read_register(reg::kStatus) == 0 && block < 64) {
    board.write_memory(address_of(block++), std::vector<std::uint8_t>{0xAB});
  }
  EXPECT_EQ(block - 1, 15u);
}

// Some 13,000 rays come to blocks that are not there.
TEST(MemoryLimit, RaysThatWaitForBlocksCount) {
  std::array<Completion, 2> waited;
  for (const bool much : {false, true}) {
    BareBoard board = limited(much ? 64 : 4);
    board.load_volume({64, 64, 32}, [](int, int, int) { return wire::Voxel{100, 0, 0, 0}; });
    board.write_memory(wire::kAbsentFlags.base, std::vector<std::uint8_t>{0b1111});
    waited[much] = board.wait(board.command(render_of({64, 64, 32}, 200))).completions.at(0);
    EXPECT_LE(board.memory_bytes(), (much ? 64 : 4) * kMiB);
    board.write_memory(wire::kAbsentFlags.base, std::vector<std::uint8_t>{0});
    EXPECT_EQ(board.render(corner_view({64, 64, 32}, 16)).size(), 16u * 16);
  }
  EXPECT_EQ(waited[1].error, ErrorCode::kNone);
  EXPECT_EQ(waited[0].error, ErrorCode::kBadValue);
  EXPECT_THAT(std::string(waited[0].payload.begin(), waited[0].payload.end()),
              AllOf(HasSubstr("rays wait for blocks"), HasSubstr("--max-memory")));
}

// Of 3 x 1 x 2 blocks of eight: what irradiance (two pointers) and sums (a pointer, a bound) have for each, and 12
// bytes for each of 2^3 cells.
TEST(MemoryLimit, BlocksCountBeforeAnythingIsStored) {
  EXPECT_EQ(Aperture::bytes_of_blocks({17, 8, 9}, 8, 1),
            6 * (VolumeMemory::kBytesOfBlock + 2 * sizeof(void*) + sizeof(void*) + 8 + 8 * 12));
}

// 65,536 blocks: a result of 256 KiB for a command of 16 bytes.
TEST(HeldResults, AreCountedByWhatTheyTake) {
  BareBoard board(board_of(8, 512));
  set_size(board, 512, 256, 256);
  std::uint32_t ticket = 0;
  for (std::uint64_t commands = 1; commands <= 4; ++commands) {
    ticket = board.command(verify_of(65'536));
    EXPECT_GE(board.held_bytes(), commands * (256 << 10));
    EXPECT_LE(board.held_bytes(), commands * ((256 << 10) + 4096));
  }
  EXPECT_EQ(board.wait(ticket).completions.size(), 4u);
  EXPECT_EQ(board.held_bytes(), 0u);
}

TEST(HeldResults, PostedWritesCountUntilTheirTimeHasPassed) {
  BareBoard board;
  for (int i = 0; i < 1000; ++i) board.write_register(reg::kStep, wire::kStepOne);
  EXPECT_GT(board.held_bytes(), 100'000u);
  board.read_register(reg::kStep);
  EXPECT_EQ(board.held_bytes(), 0u);
}

TEST(Tickets, OneThatIsUnderWayIsRefusedAndFreeOnceItsCompletionHasCome) {
  BareBoard board(board_of(8, 512));
  set_size(board, 16, 16, 16);
  EXPECT_FALSE(board.send(FrameType::kCommand, 7, verify_of(8)).ticket_in_use);
  const std::uint64_t held = board.held_bytes();
  EXPECT_TRUE(board.send(FrameType::kCommand, 7, verify_of(8)).ticket_in_use);
  EXPECT_EQ(board.held_bytes(), held);
  EXPECT_EQ(board.wait(7).completions.size(), 1u);
  EXPECT_EQ(board.read_register(reg::kStatus), wire::kStatusBadCommand);
  EXPECT_FALSE(board.send(FrameType::kCommand, 7, verify_of(8)).ticket_in_use);
}

}  // namespace
}  // namespace gicube::emu
