// A board process at its limits: of memory, the system's and its own; and when it is told to end while it can't.
#include <signal.h>

#include "board_process.h"
#include "fickle_bsdf.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"
#include "good_client.h"
#include "raw_client.h"
#include "sanitizers.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::system_test {
namespace {

using reference::RawClient;
using reference::RawFrame;
using wire::ErrorCode;
using wire::FrameType;
namespace reg = wire::reg;

constexpr std::uint64_t kBlockBytes = 32 * 32 * 32 * 9 / 2;

// A client that needs to give no credit back.
RawClient open(const std::string& path) {
  RawClient client = RawClient::connect_unix(path);
  wire::VersionInfo mine;
  mine.window_slots = 1u << 20;
  mine.window_bytes = std::uint64_t{1} << 32;
  const auto answer = client.handshake(mine);
  if (!answer || answer->header.error != ErrorCode::kNone) throw std::runtime_error("the board refused us");
  return client;
}

void set_size(RawClient& client, std::uint32_t edge) {
  for (const std::uint32_t axis : {reg::kVolumeX, reg::kVolumeY, reg::kVolumeZ}) client.write_register(axis, edge);
}

void write_byte(RawClient& client, std::uint64_t block, std::uint8_t byte) {
  std::array<std::uint8_t, 9> payload{};
  wire::store(std::span<std::uint8_t>(payload), 0, wire::kVolume.base + block * kBlockBytes);
  payload[8] = byte;
  client.send(FrameType::kMemoryWrite, 0, wire::kPosted, payload);
}

RawFrame read_bytes(RawClient& client, std::uint64_t block) {
  std::array<std::uint8_t, 16> payload{};
  wire::store(std::span<std::uint8_t>(payload), 0, wire::kVolume.base + block * kBlockBytes);
  wire::store(std::span<std::uint8_t>(payload), 8, std::uint64_t{9});
  return client.call(FrameType::kMemoryRead, 1, payload).value();
}

// A byte in each block of the largest volume takes 4.5 GiB. Returns the board's last word, or nothing if it took them
// all.
std::optional<RawFrame> fill(RawClient& client) {
  std::array<std::uint8_t, 4> id{};
  wire::store(std::span<std::uint8_t>(id), 0, reg::kId);
  set_size(client, 1024);
  for (std::uint64_t block = 0; block < 32 * 32 * 32; ++block) {
    write_byte(client, block, 0xAB);
    if (block % 16 != 15) continue;  // within the board's window
    auto answer = client.call(FrameType::kRegisterRead, 1, id);
    if (!answer || answer->header.type == FrameType::kVersion) return answer;
  }
  return std::nullopt;
}

TEST(MemoryLimit, OfTheSystemEndsASessionAndNobodySeesWhatItHadWritten) {
  if (reference::kHasAddressSanitizer || reference::kHasThreadSanitizer)
    GTEST_SKIP() << "a sanitizer takes more address space than any limit";
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  BoardProcess process({"--listen", "unix:" + path, "--set", "asic.max_volume_voxels=1024", "--set", "threads=1"});
  process.read_line();
  process.limit_memory(std::uint64_t{1} << 29);
  for (int round = 0; round < 2; ++round) {
    {
      RawClient client = open(path);
      const auto last = fill(client);
      ASSERT_TRUE(last.has_value());
      EXPECT_EQ(last->header.error, ErrorCode::kInternal);
      EXPECT_EQ(last->header.id, 0u) << "it is the session's end, not a frame's answer";
      EXPECT_THAT(last->text(), HasSubstr("no memory left"));
    }
    RawClient client = open(path);
    EXPECT_EQ(client.read_register(reg::kVolumeX), 0u);
    EXPECT_EQ(read_bytes(client, 0).header.error, ErrorCode::kBadAddress);
    set_size(client, 1024);
    EXPECT_EQ(read_bytes(client, 0).payload, std::vector<std::uint8_t>(9));
    write_byte(client, 5, 0xCD);
    EXPECT_EQ(read_bytes(client, 5).payload[0], 0xCD);
  }
}

TEST(MemoryLimit, OfABoardIsRefusedByNameAndWhatFitsIsTheSameToTheBit) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  std::vector<std::string> arguments{"--listen", "unix:" + path, "--quiet", "--max-memory", "8"};
  std::optional<BoardProcess> process(std::in_place, arguments);
  process->read_line();
  Round limited, free;
  {
    Board board = Board::open("unix:" + path);
    const std::vector<std::byte> samples(128 * 128 * 128, std::byte{9});  // 64 blocks of 144 KiB
    const VolumeView large{.samples = samples, .type = SampleType::kUint8, .dims = {128, 128, 128}};
    EXPECT_THAT([&] { board.load_volume(large); },
                ThrowsMessage<Rejected>(AllOf(HasSubstr("memory: expected at most 8 MiB for volume, words and image"),
                                              HasSubstr("got 9 MiB"))));
    prepare(board);
    work(board);
  }
  {
    Board board = Board::open("unix:" + path);
    prepare(board);
    limited = work(board);
  }
  arguments.resize(3);
  process.emplace(arguments);
  process->read_line();
  Board board = Board::open("unix:" + path);
  prepare(board);
  free = work(board);
  EXPECT_EQ(limited, free);
}

// A board with the fickle routine, by a path that no other one has.
class FickleBoard {
 public:
  FickleBoard() {
    std::filesystem::create_symlink(GICUBE_TESTS_DIR "/fickle_bsdf.so", routine_);
    std::vector<std::string> arguments = small_board();
    arguments.insert(arguments.end(),
                     {"--listen", "unix:" + path, "--management", "unix:" + management, "--bsdf", routine_});
    process.emplace(arguments);
    process->read_line();
    process->read_line();
    board.emplace(Board::open("unix:" + path));
    prepare(*board);
  }

  void illuminate(emu::Whim whim, const Progress& progress = {}) {
    board->set_material(
        {.scattering = 1, .bsdf = Bsdf::kTrap, .routine = kFirstUserRoutine, .parameters = {static_cast<float>(whim)}});
    const std::vector<Light> lights{PointLight{.position = {11.5, 12.5, 10.5}}};
    board->illuminate(lights, {}, progress);
  }

  // How many processes have its routine, once they are as many as wanted or ten seconds are over.
  std::size_t routines(bool wants_some) const {
    std::size_t found = 0;
    for (int look = 0; look < 1000; ++look) {
      found = 0;
      for (const auto& process_folder : std::filesystem::directory_iterator("/proc")) {
        std::ifstream file(process_folder.path() / "cmdline", std::ios::binary);
        const std::string line(std::istreambuf_iterator<char>(file), {});
        if (line.starts_with("gicube-plug-in-host") && line.find(routine_) != std::string::npos) ++found;
      }
      if ((found > 0) == wants_some) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return found;
  }

 private:
  const reference::TemporaryDirectory folder_;
  const std::string routine_ = folder_.file("routine.so");

 public:
  const std::string path = folder_.file("board"), management = folder_.file("management");
  std::optional<BoardProcess> process;
  std::optional<Board> board;
};

TEST(Ending, ASignalEndsAProcessWhoseRoutineNeverDoes) {
  FickleBoard fickle;
  bool told = false;
  const auto end_it = [&](std::uint32_t, std::uint32_t) {
    if (!std::exchange(told, true)) fickle.process->send_signal(SIGTERM);
  };
  EXPECT_THROW(fickle.illuminate(emu::Whim::kStuck, end_it), DeviceLost);
  EXPECT_EQ(fickle.process->exit_code(), 0);
  EXPECT_FALSE(std::filesystem::exists(fickle.path));
  EXPECT_FALSE(std::filesystem::exists(fickle.management));
  EXPECT_THAT(fickle.process->read_errors(), HasSubstr("work that had not ended after 900 ms was aborted"));
  EXPECT_EQ(fickle.routines(false), 0u) << "no process is left behind";
}

TEST(Ending, OfABoardThatIsKilledEndsItsRoutines) {
  FickleBoard fickle;
  fickle.illuminate(emu::Whim::kRetroreflect);
  EXPECT_GE(fickle.routines(true), 2u) << "one that has loaded the routine, and one for each call at a time";
  fickle.process->send_signal(SIGKILL);
  EXPECT_EQ(fickle.routines(false), 0u);
}

TEST(ScatteringRoutine, ThatEndsItsProcessFailsItsCommandAndNeitherSessionNorBoard) {
  FickleBoard fickle;
  for (const emu::Whim whim : {emu::Whim::kSegfault, emu::Whim::kExit, emu::Whim::kEndless}) {
    EXPECT_THROWS(Rejected, "routine 8 \"fickle\": ", fickle.illuminate(whim));
    EXPECT_NO_THROW(fickle.illuminate(emu::Whim::kRetroreflect));
  }
  EXPECT_FALSE(fickle.process->has_ended());
}

TEST(ScatteringRoutine, CannotReadTheBoardsMemory) {
  FickleBoard fickle;
  EXPECT_NO_THROW(fickle.illuminate(emu::Whim::kReadBoard));
}

}  // namespace
}  // namespace gicube::system_test
