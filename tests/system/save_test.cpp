// Board::save() and restore(): a program that goes on in another process, or on another board, can't tell that it ever
// stopped.
#include "board_process.h"
#include "cut_link.h"
#include "gicube/board.h"
#include "gicube/wire/checksum.h"
#include "random_program.h"
#include "seeds.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::system_test {
namespace {

using reference::TemporaryDirectory;
using testing::ElementsAreArray;

std::vector<std::string> draw_assignments(Dice& dice, const char* fidelity) {
  std::vector<std::string> all = emu::draw_machine(dice, kBlock);
  all.push_back(std::string("fidelity=") + fidelity);
  return all;
}

std::string in_uri(const std::vector<std::string>& assignments) {
  std::string uri = "emu:?threads=1";
  for (const std::string& each : assignments) uri += "&set=" + each;
  return uri;
}

constexpr int kSteps = 24;

std::vector<std::string> all_of(RandomProgram program, Board board) {
  program.begin(board);
  for (int i = 0; i < kSteps; ++i) program.step(board);
  program.end(board);
  return program.heard();
}

class RandomSave : public testing::TestWithParam<std::tuple<const char*, unsigned>> {};

// Memory errors too: the plan of faults goes on where it was, though the second process is told none.
TEST_P(RandomSave, GoesOnInAnotherProcessAsIfItHadNeverStopped) {
  const auto [fidelity, seed] = GetParam();
  const TemporaryDirectory folder;
  Dice dice(seed * 31 + 5);
  const bool in_bricks = dice.chance(30);
  const int edge = in_bricks ? 40 : 20;
  std::vector<std::string> assignments = draw_assignments(dice, fidelity);
  if (in_bricks) assignments.emplace_back("asic.max_volume_voxels=32");
  const std::string uri = in_uri(assignments);
  SCOPED_TRACE(uri);
  const std::string plan = folder.file("plan"), saved = folder.file("saved");
  std::ofstream(plan) << "random { seed: " << seed
                      << " kinds: [duplicate, memory_silent, memory_detected] mean_messages: 30 first_message: 40 }\n";
  const std::string faulty = dice.chance(60) ? "&faults=" + plan : "";
  const auto never_stopped = all_of(RandomProgram(seed, edge), Board::open(uri + faulty));

  RandomProgram program(seed, edge);
  const int stop = dice.number(0, kSteps);
  const auto begin = [&] {
    Board board = Board::open(uri + faulty);
    program.begin(board);
    for (int i = 0; i < stop; ++i) program.step(board);
    board.save(saved);
    RandomProgram same = program;
    same.step(board);  // it lives on, and what it does then is not in the file
  };
  begin();
  Board board = Board::open("emu:?restore=" + saved);
  for (int i = stop; i < kSteps; ++i) program.step(board);
  program.end(board);
  EXPECT_THAT(program.heard(), ElementsAreArray(never_stopped));
}

INSTANTIATE_TEST_SUITE_P(Levels, RandomSave, testing::Combine(testing::Values("functional", "cycle"), seeds(16)),
                         [](const auto& each) {
                           return std::string(std::get<0>(each.param)) + std::to_string(std::get<1>(each.param));
                         });

// A board at a socket that is damaged, cut and doubled by its plan of faults.
struct FaultyServer {
  FaultyServer(const TemporaryDirectory& folder, const std::string& name, const std::vector<std::string>& assignments,
               const std::string& plan)
      : uri("unix:" + folder.file(name)), process(arguments(assignments, plan, uri)) {
    process.read_line();
  }
  static std::vector<std::string> arguments(const std::vector<std::string>& assignments, const std::string& plan,
                                            const std::string& uri) {
    std::vector<std::string> all{"--listen", uri, "--quiet", "--faults", plan};
    for (const std::string& each : assignments) all.insert(all.end(), {"--set", each});
    return all;
  }
  Board open() const { return Board::open(uri, {.reopen_attempts = 50}); }

  std::string uri;
  BoardProcess process;
};

class RandomLink : public testing::TestWithParam<unsigned> {};

TEST_P(RandomLink, ThatLosesAndDamagesFramesChangesNothingForABoardThatGoesOn) {
  const unsigned seed = GetParam();
  const TemporaryDirectory folder;
  Dice dice(seed * 17 + 3);
  const auto assignments = draw_assignments(dice, dice.one_of({"functional", "cycle"}));
  const std::string plan = folder.file("plan");
  std::ofstream(plan)
      << "random { seed: " << seed
      << " kinds: [drop, corrupt, duplicate, link_loss, slow] mean_messages: 25 "
         "bytes_per_second: 50000000 slow_messages: 3 }\n"
         "random { seed: 5 kinds: [memory_silent, memory_detected] mean_messages: 40 first_message: 60 }\n";
  const FaultyServer first(folder, "a", assignments, plan), second(folder, "b", assignments, plan);
  const auto never_stopped = all_of(RandomProgram(seed), first.open());

  // Back and forth between two boards; the one that is left goes on from bytes.
  const FaultyServer third(folder, "c", assignments, plan);
  RandomProgram program(seed);
  Board here = third.open(), there = second.open();
  program.begin(here);
  const int stop = dice.number(0, kSteps - 2), again = dice.number(stop, kSteps - 1);
  for (int i = 0; i < kSteps; ++i) {
    if (i == stop) there.restore(here.save());
    if (i == again) here.restore(there.save());
    program.step(i < stop || i >= again ? here : there);
  }
  program.end(here);
  EXPECT_THAT(program.heard(), ElementsAreArray(never_stopped));
}

INSTANTIATE_TEST_SUITE_P(Faulty, RandomLink, seeds(10));

// A connection carries a megabyte, and a checkpoint has several. One attempt in a row is enough as long as each carries
// something.
TEST(CutLink, OfAMegabyteEachTimeSavesAndRestores) {
  const TemporaryDirectory folder;
  BoardProcess process({"--listen", "unix:" + folder.file("board"), "--quiet"});
  process.read_line();
  CutLink link(folder.file("link"), folder.file("board"));
  Board board = Board::open("unix:" + folder.file("link"), {.reopen_attempts = 1});
  Dice dice(7);
  std::vector<std::uint8_t> voxels(128 * 128 * 128);
  for (std::uint8_t& voxel : voxels) voxel = static_cast<std::uint8_t>(dice.number(0, 255));
  board.load_volume({.samples = std::as_bytes(std::span(voxels)), .dims = {128, 128, 128}});
  board.set_transfer_function(step_function(0.4));
  const Image image = board.render(front_view(20));
  const std::vector<std::byte> whole = board.save();
  ASSERT_GT(whole.size(), 4'000'000u);
  link.cut_after(1'000'000);
  const std::vector<std::byte> cut = board.save();
  EXPECT_GE(link.cuts(), 4);
  EXPECT_EQ(cut.size(), whole.size());
  board.clear_irradiance(1);
  board.restore(cut);
  EXPECT_GE(link.cuts(), 8);
  link.cut_after(0);
  EXPECT_EQ(board.read_framebuffer(), image);
  EXPECT_EQ(board.render(front_view(20)), image);
}

// ---- one board

Board small_board(const std::string& options = "") {
  Board board = Board::open(std::string(kSmallBlocks) + options);
  board.load_volume(BoxVolume(20, 4, 15).view());
  board.set_transfer_function(step_function(0.4));
  return board;
}

TEST(SavedBoard, DamagedAnywhereIsRefusedByItsFieldAndTheBoardLivesOn) {
  Board board = small_board();
  const Image before = board.render(front_view(20));
  const std::vector<std::byte> saved = board.save();
  const Picoseconds now = board.now();
  Dice dice(3);
  for (int i = 0; i < 60; ++i) {
    std::vector<std::byte> bytes = saved;
    const auto at = static_cast<std::size_t>(dice.number(0, static_cast<int>(saved.size()) - 1));
    bytes[at] ^= static_cast<std::byte>(1 << dice.number(0, 7));
    EXPECT_THROWS(BadArgument, "checkpoint.", board.restore(bytes)) << at;
    bytes.resize(at);
    EXPECT_THROWS(BadArgument, "checkpoint.", board.restore(bytes)) << at;
  }
  EXPECT_EQ(board.now(), now);
  EXPECT_EQ(board.read_framebuffer(), before);
}

// The driver's part with other bytes and the checksum of what it now is: no driver has written it.
TEST(SavedBoard, MadeUpIsRefusedByItsFieldOrGoesOnAndNothingElse) {
  Board board = small_board();
  const Image image = board.render(front_view(20));
  board.submit(std::vector<HostRay>(9, ray_between(1, {2, 2, 2}, {18, 17, 16})));
  const std::vector<std::byte> saved = board.save();
  const auto find = [&saved](std::string_view name) {
    const auto* const text = reinterpret_cast<const char*>(saved.data());
    return std::string_view(text, saved.size()).find(name);
  };
  Dice dice(8);
  int refused = 0, taken = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<std::byte> bytes = saved;
    const auto near = find(
        dice.one_of({"host.driver", "device.now", "device.registers", "batches.tickets", "part0.rays",
                     "tables.codebook", "tag0.function", "shading", "reflectance_source", "board.info", "board.units",
                     "board.sampling", "board.block_sums", "volume.shape", "volume.statistics", "volume.flags"}));
    ASSERT_LT(near, saved.size());
    for (int edits = dice.number(1, 3); edits > 0; --edits) {
      bytes[near + static_cast<std::size_t>(dice.number(0, 60))] = static_cast<std::byte>(dice.number(0, 255));
    }
    const std::span<std::uint8_t> words(reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size());
    wire::store(words, words.size() - 4, wire::crc32c(words.first(words.size() - 5)));
    try {
      board.restore(bytes);
      ++taken;
      board.poll();
      board.render(front_view(20));
    } catch (const DeviceLost&) {
      throw;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 30);
  EXPECT_GT(taken, 30);
  board.restore(saved);
  EXPECT_EQ(board.read_framebuffer(), image);
}

TEST(SavedBoard, OfOtherQueuesIsRefusedInTheBoardsWords) {
  Board board = small_board(), other = small_board("&set=asic.queue_rays=17");
  const Picoseconds now = other.now();
  const auto saved = board.save();
  EXPECT_THROWS(Rejected, "config.asic.queue_rays: expected 256, as in the checkpoint, got 17", other.restore(saved));
  EXPECT_EQ(other.now(), now);
  EXPECT_NO_THROW(other.render(front_view(20)));
}

TEST(SavedBoard, CostsNoSimulatedTimeAndNoCounter) {
  Board board = small_board();
  const Picoseconds now = board.now();
  const auto counters = board.counters().list();
  board.save();
  board.restore(board.save());
  EXPECT_EQ(board.now(), now);
  const auto after = board.counters();
  for (const Counter& each : counters) {
    if (each.name.starts_with("emulator.")) continue;
    EXPECT_EQ(after.value(each.name), each.value) << each.name;
  }
}

TEST(SavedBoard, ServesForksWithOtherBusesLevelsAndPolicies) {
  const TemporaryDirectory folder;
  const std::string saved = folder.file("warm");
  Board board = small_board("&fidelity=cycle");
  board.save(saved);
  const Image image = board.render(front_view(20));
  std::map<std::string, Picoseconds> frames;
  for (const std::string bus : {"pci33", "agp1x", "agp4x"}) {
    Board fork = Board::open("emu:?restore=" + saved + "&bus=" + bus);
    EXPECT_EQ(fork.info().agp, bus != "pci33");
    const Picoseconds begin = fork.now();
    EXPECT_EQ(fork.render(front_view(20)), image);
    frames[bus] = fork.now() - begin;
  }
  EXPECT_GT(frames["pci33"], frames["agp1x"]);
  Board quick = Board::open("emu:?restore=" + saved + "&fidelity=functional");
  EXPECT_EQ(quick.info().fidelity, Fidelity::kFunctional);
  EXPECT_NE(quick.info().config_hash, board.info().config_hash);
  EXPECT_EQ(quick.render(front_view(20)), image);
  EXPECT_THROWS(BadArgument, "asic.processors: expected 4, as in the checkpoint, got 2",
                Board::open("emu:?restore=" + saved + "&set=asic.processors=2"));
}

TEST(SavedBoard, HasTheBlocksForReopenIfItWasToldToKeepThem) {
  Board keeper = open_board_process({.keep_volume = true}).board;
  keeper.load_volume(BoxVolume(20, 4, 15).view());
  keeper.set_transfer_function(step_function(0.4));
  const Image image = keeper.render(front_view(20));
  const auto saved = keeper.save();
  auto [board, id] = open_board_process({.keep_volume = true});
  board.restore(saved);
  ::kill(id, SIGKILL);
  EXPECT_THROW(board.read_framebuffer(), DeviceLost);
  EXPECT_TRUE(board.reopen().volume);
  EXPECT_EQ(board.render(front_view(20)), image);
}

TEST(SavedBoard, HoldsAVolumeInBricks) {
  const std::string small = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=32";
  Board board = Board::open(small);
  board.load_volume(BoxVolume(64, 4, 59).view());
  board.set_transfer_function(step_function(0.4));
  board.render(front_view(64));
  Board other = Board::open(small);
  other.restore(board.save());
  View view = front_view(64);
  view.eye.x += 30;
  EXPECT_EQ(other.render(view), board.render(view));
  EXPECT_EQ(other.now(), board.now());
}

TEST(SavedBoard, GoesOnAtAServerThatBeganWithIt) {
  const TemporaryDirectory folder;
  const std::string saved = folder.file("warm");
  Board board = small_board();
  board.save(saved);
  BoardProcess process({"--listen", "unix:" + folder.file("s"), "--quiet", "--restore", saved});
  process.read_line();
  const std::string uri = "unix:" + folder.file("s");
  const Image image = board.render(front_view(20));
  for (int session = 0; session < 2; ++session) {
    Board there = Board::open(uri, {.go_on = true});
    EXPECT_EQ(there.render(front_view(20)), image);
    EXPECT_EQ(there.now(), board.now());
  }
  Board fresh = Board::open(uri);  // resets it, as ever
  EXPECT_THROW(fresh.dims(), Rejected);
}

TEST(SavedBoard, IsAskedForWhereThereIsNone) {
  Board board = small_board();  // after which the board's program is known
  EXPECT_THROWS(OpenFailed, "expected a board process with --restore", Board::open("emu:", {.go_on = true}));
  EXPECT_THROWS(BadArgument, "file: expected a file", board.restore("/nowhere/saved"));
  EXPECT_THROWS(Error, "/nowhere/saved", board.save("/nowhere/saved"));
  EXPECT_NO_THROW(board.render(front_view(20)));
}

}  // namespace
}  // namespace gicube::system_test
