// Checkpoints whose clocks were made up: what no command comes to is refused, and any other board goes on within a
// short time.
#include <condition_variable>
#include <cstdio>

#include "commands_rig.h"
#include "random_session.h"
#include "saved_board.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kSmallBlock = 8;

// Cancels what takes long, and ends the test if that is not heard.
class Watchdog {
 public:
  explicit Watchdog(std::string what) : what_(std::move(what)), thread_([this] { watch(); }) {}
  ~Watchdog() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

 private:
  void watch() {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, std::chrono::seconds(60), [this] { return done_; })) return;
    fprintf(stderr, "still at work after a minute: %s\n", what_.c_str());
    std::_Exit(1);
  }

  std::string what_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread thread_;
};

struct SavedMachine {
  SavedMachine(const char* memory, bool in_command) {
    const v1::BoardConfig config =
        config_with({"fidelity=cycle", "asic.block_voxels=8", "asic.processors=2", std::string("memory=") + memory});
    Saver saver;
    const auto board = board_of(config, &saver);
    host.begin(*board);
    for (int i = 0; i < 25; ++i) host.step(*board);
    bytes = saved(*board);
    for (int i = 0; in_command && saver.bytes().empty() && i < 40; ++i) {
      saver.save_in(300, *board);
      host.step(*board);
    }
    if (in_command) bytes = saver.bytes();
  }

  RandomHost host{3, kSmallBlock};
  std::string bytes;
};

std::string fault_of(const std::string& bytes) {
  return message_of<CheckpointFault>([&] { restored(bytes); });
}

TEST(CheckpointClocks, WithAWriteOfTheDspAfterTheEndOfTimeAreRefusedByTheirField) {
  const SavedMachine machine("rdram", false);
  const std::string bytes = changed(machine.bytes, [](v1::Checkpoint& message) {
    v1::StateField& written = field(message, "level.machine.dsp.core.written");
    for (int i = 0; i < 2; ++i) written.set_numbers(i, (std::uint64_t{1} << 63) - 1);
  });
  EXPECT_THAT(fault_of(bytes),
              testing::MatchesRegex("checkpoint: level.machine.dsp.core.written: expected a time of at most "
                                    "[0-9]+ as number 1, got 9223372036854775807"));
}

// Each number of the level in turn.
class MadeUpClocks : public testing::TestWithParam<std::tuple<const char*, bool>> {};

TEST_P(MadeUpClocks, AreRefusedOrEndSoon) {
  const auto [memory, in_command] = GetParam();
  const SavedMachine machine(memory, in_command);
  ASSERT_FALSE(machine.bytes.empty());
  v1::Checkpoint message;
  ASSERT_TRUE(message.ParseFromString(machine.bytes));
  int refused = 0, taken = 0;
  for (int i = 0; i < message.fields_size(); ++i) {
    const std::string& name = message.fields(i).name();
    if (!name.starts_with("level.") && !name.starts_with("timeline.")) continue;
    if (name.ends_with(".tags") || name.ends_with(".milliseconds")) continue;
    const int numbers = message.fields(i).numbers_size();
    for (int number = 0; number<numbers; number += numbers> 40 ? 17 : 1) {
      for (const std::uint64_t value : {std::uint64_t{1} << 41, (std::uint64_t{1} << 63) - 1}) {
        const std::string bytes =
            changed(machine.bytes, [&](v1::Checkpoint& all) { all.mutable_fields(i)->set_numbers(number, value); });
        const Watchdog watchdog(name + " number " + std::to_string(number) + ": " + std::to_string(value));
        try {
          const auto board = restored(bytes);
          ++taken;
          RandomHost host = machine.host;
          for (int step = 0; step < 2; ++step) host.step(*board);
        } catch (const CheckpointFault&) {
          ++refused;
        }
      }
    }
  }
  RecordProperty("refused", refused);
  RecordProperty("taken", taken);
  EXPECT_GT(refused, 500);
}

INSTANTIATE_TEST_SUITE_P(Boards, MadeUpClocks, testing::Combine(testing::Values("rdram", "ddr"), testing::Bool()),
                         [](const testing::TestParamInfo<MadeUpClocks::ParamType>& each) {
                           return std::string(std::get<0>(each.param)) + (std::get<1>(each.param) ? "InACommand" : "");
                         });

}  // namespace
}  // namespace gicube::emu
