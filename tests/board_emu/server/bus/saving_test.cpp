// A board is saved in the middle of a command, and another process's board ends it.
#include <boost/asio/post.hpp>

#include "bare_board.h"
#include "board/checkpoint.h"
#include "server/bus/board_slot.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr std::array<int, 3> kSize{32, 32, 32};
constexpr std::uint32_t kTicket = 99;

TransactionResult send(BoardSlot& slot, wire::FrameType type, std::uint32_t id,
                       const std::vector<std::uint8_t>& payload, Progress& work) {
  wire::FrameHeader header;
  header.type = type;
  header.id = id;
  return slot.board().transact(header, payload, work);
}

// Slots whose boards take a picture of an empty volume on their own threads.
struct Rendering {
  explicit Rendering(int image, std::shared_ptr<const Checkpoint> start = nullptr)
      : slot(0, config(), {}, nullptr, kUnlimitedMemory, std::move(start)), view(wire::kRenderCommandBytes) {
    wire::encode(corner_view(kSize, image), view);
  }
  ~Rendering() { slot.settle(); }

  static v1::BoardConfig config() {
    v1::BoardConfig config;
    config.set_fidelity(v1::cycle);
    return config;
  }
  void begin() {
    boost::asio::post(slot.compute(), [this] {
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        std::vector<std::uint8_t> size(8);
        wire::store(std::span(size), 0, wire::reg::kVolumeX + 4 * axis);
        wire::store(std::span(size), 4, static_cast<std::uint32_t>(kSize[axis]));
        send(slot, wire::FrameType::kRegisterWrite, axis, size, work);
      }
      send(slot, wire::FrameType::kCommand, kTicket, view, work);
    });
  }
  // When it is done, and the card's counters.
  std::string end() {
    slot.settle();
    std::vector<std::uint8_t> ticket(4);
    wire::store(std::span(ticket), 0, kTicket);
    const TransactionResult result = send(slot, wire::FrameType::kWait, 100, ticket, work);
    std::string out = std::to_string(result.reply->time_ps);
    for (const wire::Counter& each : slot.counters().counters) {
      if (!each.name.starts_with("emulator.")) out += '\n' + each.name + ' ' + std::to_string(each.value);
    }
    return out;
  }

  BoardSlot slot;
  std::vector<std::uint8_t> view;
  Progress work;
};

std::string end_of(const std::string& file, int image) {
  Rendering other(image, std::make_shared<const Checkpoint>(Checkpoint::read(file)));
  return other.end();
}

TEST(BoardSlot, SavesABoardWhileItWorksAtACommand) {
  const reference::TemporaryDirectory folder;
  const std::string file = std::string(folder.path()) + "/working";
  constexpr int kImage = 400;
  Rendering rendering(kImage);
  rendering.begin();
  while (rendering.work.done == 0) std::this_thread::yield();
  BoardSlot::Saved saved;
  std::string reason;
  ASSERT_EQ(rendering.slot.save(file, saved, reason), BoardSlot::Configured::kDone) << reason;
  EXPECT_TRUE(Checkpoint::read(file).header().in_command());
  EXPECT_LT(rendering.work.done, rendering.work.all);
  EXPECT_EQ(end_of(file, kImage), rendering.end());
}

TEST(BoardSlot, SavesABoardWhereTheDebuggerHoldsIt) {
  const reference::TemporaryDirectory folder;
  constexpr int kImage = 24;
  for (const std::string place : {"cycle 1500", "ray 200", "command"}) {
    Rendering rendering(kImage);
    Debugger& debugger = rendering.slot.debugger();
    ASSERT_TRUE(debugger.attach());
    const auto say = [&](const std::string& line) { return debugger.carry_out(line, [] { return false; }); };
    say("break " + place);
    rendering.begin();
    const std::string where = say("continue 20").text;
    ASSERT_TRUE(debugger.is_paused()) << place << ": " << where;
    const std::string file = std::string(folder.path()) + '/' + place;
    BoardSlot::Saved saved;
    std::string reason;
    ASSERT_EQ(rendering.slot.save(file, saved, reason), BoardSlot::Configured::kDone) << reason;
    EXPECT_EQ(say("where").text, where);
    debugger.detach();
    EXPECT_TRUE(Checkpoint::read(file).header().in_command());
    EXPECT_EQ(end_of(file, kImage), rendering.end()) << place;
  }
}

TEST(BoardSlot, GoesOnInACommandWithAnotherBusButNotWithAnotherPolicy) {
  const reference::TemporaryDirectory folder;
  Rendering rendering(24);
  ASSERT_TRUE(rendering.slot.debugger().attach());
  rendering.slot.debugger().carry_out("break cycle 1500", [] { return false; });
  rendering.begin();
  rendering.slot.debugger().carry_out("continue 20", [] { return false; });
  BoardSlot::Saved saved;
  std::string reason;
  const std::string file = std::string(folder.path()) + "/standing";
  ASSERT_EQ(rendering.slot.save(file, saved, reason), BoardSlot::Configured::kDone) << reason;
  rendering.slot.debugger().detach();
  Rendering other(24, std::make_shared<const Checkpoint>(Checkpoint::read(file)));
  EXPECT_EQ(other.slot.configure("sorter { policy: most_contribution }", reason), BoardSlot::Configured::kFaulty);
  EXPECT_EQ(reason, "sorter.policy: expected most_rays, as in the checkpoint, got most_contribution");
  EXPECT_EQ(other.slot.configure("bus { model: agp4x }", reason), BoardSlot::Configured::kDone) << reason;
}

}  // namespace
}  // namespace gicube::emu
