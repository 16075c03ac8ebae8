// A checkpoint is all that a board is: who goes on from it can't tell that the board was ever another.
#include "saved_board.h"

#include "commands_rig.h"
#include "random_session.h"
#include "seeds.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

using testing::ElementsAreArray;

constexpr int kBlock = 8;

std::vector<std::string> texts(const Board::Snapshot& snapshot) {
  std::vector<std::string> out{std::to_string(snapshot.simulated_ps), std::to_string(snapshot.machine.cycle)};
  for (const wire::Counter& counter : snapshot.counters)
    if (counter.name != "emulator.cycles_ahead") out.push_back(counter.name + ' ' + std::to_string(counter.value));
  for (const auto& channel : snapshot.machine.packets) {
    for (const std::uint64_t packets : channel) out.push_back("packets " + std::to_string(packets));
  }
  return out;
}

v1::BoardConfig draw_board(Dice& dice, const char* fidelity) {
  std::vector<std::string> assignments = draw_machine(dice, kBlock);
  const auto add = [&assignments](std::initializer_list<const char*> more) {
    assignments.insert(assignments.end(), more.begin(), more.end());
  };
  assignments.push_back(std::string("fidelity=") + fidelity);
  if (dice.chance(30)) add({"asic.datapath=wide", "cache.irradiance=with_voxels"});
  return config_with(assignments);
}

// The fields in which two checkpoints differ.
std::vector<std::string> differences(const std::string& a, const std::string& b) {
  v1::Checkpoint first, second;
  if (!first.ParseFromString(a) || !second.ParseFromString(b)) return {"not a message"};
  std::vector<std::string> out;
  for (int i = 0; i < std::max(first.fields_size(), second.fields_size()); ++i) {
    const std::string one = i < first.fields_size() ? first.fields(i).SerializeAsString() : "";
    const std::string other = i < second.fields_size() ? second.fields(i).SerializeAsString() : "";
    if (one != other) out.push_back(i < first.fields_size() ? first.fields(i).name() : second.fields(i).name());
  }
  return out;
}

class RandomBoard : public testing::TestWithParam<std::tuple<const char*, unsigned>> {};

// Between two transactions and in commands. A board that was saved goes on too: saving has changed nothing.
TEST_P(RandomBoard, GoesOnFromCheckpointsAsIfItHadNeverStopped) {
  const auto [fidelity, seed] = GetParam();
  Dice dice(seed * 7 + 1);
  const v1::BoardConfig config = draw_board(dice, fidelity);
  SCOPED_TRACE(config.ShortDebugString());
  constexpr int kSteps = 40;
  RandomHost host(seed, kBlock);
  auto never_stopped = board_of(config);
  host.begin(*never_stopped);
  for (int i = 0; i < kSteps; ++i) host.step(*never_stopped);

  RandomHost same(seed, kBlock);
  int between = 0, in_commands = 0;
  auto saver = std::make_unique<Saver>();
  auto board = board_of(config, saver.get());
  const auto go_on_from = [&](const std::string& bytes) {
    auto next = std::make_unique<Saver>();
    board = restored(bytes, next.get());
    saver = std::move(next);
  };
  same.begin(*board);
  for (int i = 0; i < kSteps; ++i) {
    if (dice.chance(15)) {
      const std::string bytes = saved(*board);
      if (dice.chance(70)) go_on_from(bytes);
      ++between;
    }
    const bool has_rest = board->in_command();  // the step comes after it
    const RandomHost before = same;
    saver->save_in(static_cast<Cycle>(dice.number(0, 1 << dice.number(0, 13))), *board);
    same.step(*board);
    if (saver->bytes().empty()) continue;
    ++in_commands;
    if (dice.chance(20)) continue;
    const std::string bytes = saver->bytes();
    go_on_from(bytes);
    ASSERT_THAT(differences(saved(*board), bytes), IsEmpty()) << "step " << i;
    if (!has_rest) continue;
    same = before;
    --i;
  }
  RecordProperty("between", between);
  RecordProperty("in_commands", in_commands);
  Progress work;
  board->go_on(work);
  EXPECT_THAT(differences(saved(*board), saved(*never_stopped)), IsEmpty());
  host.end(*never_stopped);
  same.end(*board);
  EXPECT_THAT(same.heard(), ElementsAreArray(host.heard()));
  EXPECT_THAT(texts(board->snapshot()), ElementsAreArray(texts(never_stopped->snapshot())));
  EXPECT_EQ(board->held_bytes(), never_stopped->held_bytes());
}

// A link that damages memory at random, as its plan says; host rays are under way all the time.
std::unique_ptr<FaultPoint> draw_link(Dice& dice) {
  auto link = std::make_unique<FaultPoint>();
  const std::string means = std::to_string(dice.number(3, 40));
  link->set_plan("random { seed: " + std::to_string(dice.number(0, 999)) +
                 " kinds: [memory_silent, memory_detected] mean_messages: " + means + " max_faults: 6 }");
  return link;
}

void connect(RandomHost& host, FaultPoint& link) {
  host.on_send([&link](Board& board, std::size_t bytes) {
    if (const auto error = link.taken(bytes).memory_error) board.add_memory_error(*error);
  });
}

std::unique_ptr<FaultPoint> restored_link(const std::string& bytes) {
  SavedFaults faults;
  Checkpoint(bytes).surroundings([&faults](Archive& archive) { archive("host.faults", faults); });
  auto link = std::make_unique<FaultPoint>();
  link->restore(faults);
  return link;
}

TEST_P(RandomBoard, GoesOnWithTheFaultPlanOfItsLink) {
  const auto [fidelity, seed] = GetParam();
  Dice dice(seed * 7 + 1);
  const v1::BoardConfig config = draw_board(dice, fidelity);
  SCOPED_TRACE(config.ShortDebugString());
  constexpr int kSteps = 40;
  RandomHost host(seed, kBlock);
  auto never_stopped = board_of(config);
  Dice same_dice = dice;
  const auto first_link = draw_link(dice);
  auto link = draw_link(same_dice);
  connect(host, *first_link);
  host.begin(*never_stopped);
  for (int i = 0; i < kSteps; ++i) host.step(*never_stopped);

  RandomHost same(seed, kBlock);
  auto board = board_of(config);
  connect(same, *link);
  same.begin(*board);
  const int first = dice.number(0, kSteps);
  for (int i = 0; i < kSteps; ++i) {
    if (i == first) {
      const std::string bytes = saved(*board, *link);
      board = restored(bytes);
      link = restored_link(bytes);
      connect(same, *link);
    }
    same.step(*board);
  }
  EXPECT_THAT(differences(saved(*board, *link), saved(*never_stopped, *first_link)), IsEmpty());
  host.end(*never_stopped);
  same.end(*board);
  EXPECT_THAT(same.heard(), ElementsAreArray(host.heard()));
}

std::string name_of(const testing::TestParamInfo<RandomBoard::ParamType>& each) {
  return std::string(std::get<0>(each.param)) + std::to_string(std::get<1>(each.param));
}

// All together take some minutes. At cycle level each has some ten moments between transactions and forty in commands.
INSTANTIATE_TEST_SUITE_P(WithoutTime, RandomBoard, testing::Combine(testing::Values("functional"), seeds(120)),
                         name_of);
INSTANTIATE_TEST_SUITE_P(ByCycles, RandomBoard, testing::Combine(testing::Values("cycle"), seeds(25)), name_of);

// ---- one board with something of everything

struct WarmBoard {
  explicit WarmBoard(const char* fidelity = "cycle")
      : config(config_with({std::string("fidelity=") + fidelity, "asic.block_voxels=8", "asic.processors=2"})),
        board(board_of(config)) {
    host.begin(*board);
    for (int i = 0; i < 25; ++i) host.step(*board);
    bytes = saved(*board);
  }

  v1::BoardConfig config;
  std::unique_ptr<Board> board;
  RandomHost host{3, kBlock};
  std::string bytes;
};

std::string refusal(const std::string& bytes, const v1::BoardConfig& config) {
  return message_of<CheckpointFault>([&] { Checkpoint(bytes).restore(*board_of(config)); });
}

TEST(Checkpoint, IsAMessageThatProtobufReads) {
  const WarmBoard warm;
  v1::Checkpoint message;
  ASSERT_TRUE(message.ParseFromString(warm.bytes));
  EXPECT_EQ(message.header().format(), "gicube checkpoint");
  EXPECT_EQ(message.header().config_hash(), config_hash(warm.config));
  EXPECT_EQ(message.header().simulated_ps(), warm.board->simulated_ps());
  EXPECT_EQ(message.fields(0).name(), "registers.ID");
}

TEST(Checkpoint, IsRefusedWhereverItIsDamaged) {
  const WarmBoard warm;
  Dice dice(11);
  const int last = static_cast<int>(warm.bytes.size()) - 1;
  for (int i = 0; i < 300; ++i) {
    std::string bytes = warm.bytes;
    const auto at = static_cast<std::size_t>(i < 40 ? i : dice.number(0, last));
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.number(0, 7)));
    EXPECT_THAT(refusal(bytes, warm.config), HasSubstr("checkpoint: ")) << at;
    EXPECT_THAT(refusal(warm.bytes.substr(0, at), warm.config), HasSubstr("checkpoint: ")) << at;
  }
  EXPECT_THAT(refusal(warm.bytes + 'x', warm.config), HasSubstr("checkpoint: file: expected"));
}

TEST(Checkpoint, WithAValueThatNoBoardCanHaveIsRefusedByItsField) {
  const WarmBoard warm;
  const auto refusal_of = [&warm](const char* name, const auto& change) {
    const std::string bytes = changed(warm.bytes, [&](v1::Checkpoint& message) { change(field(message, name)); });
    return refusal(bytes, warm.config);
  };
  const auto set = [](std::uint64_t number) {
    return [number](v1::StateField& field) { field.set_numbers(0, number); };
  };
  EXPECT_EQ(refusal_of("level.machine.processor1.sorter.turn", set(3)),
            "checkpoint: level.machine.processor1.sorter.turn: expected at most 2 as number 1, got 3");
  EXPECT_EQ(refusal_of("registers.VOLUME_X", set(20)),
            "checkpoint: commands.aperture.volume.size: expected the VOLUME registers, got 36");
  EXPECT_EQ(refusal_of("registers.CUT_PLANES", set(77)),
            "checkpoint: commands.CUT_PLANES: expected a value that can be written, got 77");
  EXPECT_EQ(refusal_of("commands.aperture.volume.size", set(1025)),
            "checkpoint: commands.aperture.volume.size: expected 2 to 1024 voxels, or none, got 1025");
  EXPECT_EQ(refusal_of("level.machine.processor0.cache.tags",
                       [](v1::StateField& tags) { tags.mutable_numbers()->RemoveLast(); }),
            "checkpoint: level.machine.processor0.cache.tags: expected more numbers, got 224");
  EXPECT_EQ(
      refusal_of("timeline.bus.free", set(~std::uint64_t{0})),
      "checkpoint: timeline.bus.free: expected at most 4611686018427387904 as number 1, got 18446744073709551615");
  EXPECT_EQ(refusal_of("timeline.bus.free", [](v1::StateField& each) { each.add_numbers(1); }),
            "checkpoint: timeline.bus.free: expected 1 numbers, got 2");
  EXPECT_EQ(refusal_of("timeline.bus.free", [](v1::StateField& each) { each.set_name("timeline.bus.fee"); }),
            "checkpoint: timeline.bus.free: expected a field of this name, got timeline.bus.fee");
}

TEST(Checkpoint, OfALaterVersionIsRefusedByItsNumber) {
  const WarmBoard warm;
  const std::string bytes =
      changed(warm.bytes, [](v1::Checkpoint& message) { message.mutable_header()->set_version(2); });
  EXPECT_THAT(refusal(bytes, warm.config), HasSubstr("checkpoint: header.version: expected 1, got 2 of SDK "));
}

TEST(Checkpoint, MayGoOnWithAnotherBusAndPolicyButNotWithOtherQueues) {
  WarmBoard warm;
  v1::BoardConfig other = warm.config;
  other.mutable_bus()->set_model(v1::agp4x);
  other.mutable_sorter()->set_policy(v1::most_contribution);
  other.set_threads(1);
  auto board = board_of(other);
  Checkpoint(warm.bytes).restore(*board);
  EXPECT_EQ(board->simulated_ps(), warm.board->simulated_ps());
  RandomHost there = warm.host;
  warm.host.end(*warm.board);
  there.end(*board);
  EXPECT_LT(board->simulated_ps(), warm.board->simulated_ps());

  other.mutable_asic()->set_queue_rays(17);
  EXPECT_EQ(refusal(warm.bytes, other),
            "checkpoint: config.asic.queue_rays: expected 256, as in the checkpoint, got 17");
}

// What a level computes is the same bits; its own state begins anew.
TEST(Checkpoint, OfOneLevelMakesABoardOfAnother) {
  WarmBoard warm("functional");
  v1::BoardConfig other = warm.config;
  other.set_fidelity(v1::cycle);
  auto board = board_of(other);
  Checkpoint(warm.bytes).restore(*board);
  const auto image = [](Board& of) {
    wire::FrameHeader header;
    header.type = wire::FrameType::kMemoryRead;
    std::vector<std::uint8_t> payload(16);
    wire::store(std::span(payload), 0, wire::kFramebuffer.base);
    wire::store(std::span(payload), 8, std::uint64_t{9});
    Progress work;
    return of.transact(header, payload, work).reply->payload;
  };
  EXPECT_EQ(image(*board), image(*warm.board));
}

// Whole, and a part of it as a card of several makes it.
TEST(Checkpoint, HoldsAPictureWhoseRaysWaitForBlocks) {
  for (const int parts : {0, 3}) {
    BareBoard board(blocks_of_eight());
    load_fog(board, 300);
    board.write_register(wire::reg::kBricks, 1);
    // Blocks 9 to 13, of the second layer.
    board.write_memory(wire::kAbsentFlags.base, std::vector<std::uint8_t>{0, 0x3E, 0, 0});
    wire::RenderCommand view = corner_view({17, 17, 17}, 12);
    if (parts > 0) view.strip_rows = 2, view.part = 1, view.parts = static_cast<std::uint8_t>(parts);
    const auto begun = board.render(view);
    BareBoard other(blocks_of_eight());
    Checkpoint(saved(board.board())).restore(other.board());
    const auto ended = [&view](BareBoard& of) {
      of.write_memory(wire::kAbsentFlags.base, std::vector<std::uint8_t>(4));
      EXPECT_EQ(refusal(of, wire::encoded(wire::ContinueCommand{})), "accepted");
      return of
          .read_memory(wire::kFramebuffer.base, wire::packed36_bytes(12u * static_cast<unsigned>(wire::rows_of(view))))
          .payload;
    };
    const auto picture = ended(board);
    EXPECT_EQ(ended(other), picture);
    BareBoard whole(blocks_of_eight());
    load_fog(whole, 300);
    EXPECT_NE(whole.render(view), begun);
  }
}

TEST(Checkpoint, IsReadFromAFileAndNotFromAnythingElse) {
  const reference::TemporaryDirectory folder;
  const WarmBoard warm;
  const std::filesystem::path file = std::filesystem::path(folder.path()) / "warm.checkpoint";
  save_checkpoint(*warm.board, file);
  EXPECT_EQ(std::filesystem::file_size(file), warm.bytes.size());
  EXPECT_EQ(Checkpoint::read(file).header().simulated_ps(), warm.board->simulated_ps());
  EXPECT_THROW(Checkpoint::read("/dev/zero"), std::system_error);
  EXPECT_THROW(Checkpoint::read(file.string() + ".none"), std::system_error);
}

}  // namespace
}  // namespace gicube::emu
