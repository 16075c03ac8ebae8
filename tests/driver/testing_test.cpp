#include "test.h"
#include <gicube/testing.h>

namespace gicube::test {
namespace {

class Environment : public ::testing::Test {
 protected:
  ~Environment() override {
    for (const std::string& name : set_) ::unsetenv(name.c_str());
  }
  void set(const std::string& name, const char* value) {
    ::setenv(("GICUBE_TEST_" + name).c_str(), value, 1);
    set_.push_back("GICUBE_TEST_" + name);
  }

 private:
  std::vector<std::string> set_;
};

using TestSetup = Environment;

TEST_F(TestSetup, OfAnEmptyEnvironmentIsTheBoardsDefault) {
  EXPECT_EQ(BoardSetup::from_environment().uri(), "emu:");
  EXPECT_EQ(BoardSetup::from_environment().seed, 1u);
}

TEST_F(TestSetup, PutsWhatTheEnvironmentSaysIntoTheUri) {
  set("BUS", "agp2x");
  set("FIDELITY", "cycle");
  set("CONFIG", "/tmp/a&b.textproto");
  set("SET", "asic.processors=2  dsp.run_rays=8");
  set("FAULTS", "/tmp/100% bad");
  set("SEED", "18446744073709551615");
  const BoardSetup setup = BoardSetup::from_environment();
  EXPECT_EQ(setup.uri(),
            "emu:?config=/tmp/a%26b.textproto&fidelity=cycle&bus=agp2x&set=asic.processors=2&set=dsp.run_rays=8"
            "&faults=/tmp/100%25%20bad");
  EXPECT_EQ(setup.seed, 18446744073709551615u);
}

TEST_F(TestSetup, ABoardThatThereIsComesBeforeAllOthers) {
  set("BOARD", "unix:/run/board");
  set("BUS", "agp2x");
  EXPECT_EQ(BoardSetup::from_environment().uri(), "unix:/run/board");
}

TEST_F(TestSetup, RefusesASeedThatIsNoNumber) {
  for (const char* seed : {"x", "-1", "1 ", "18446744073709551616"}) {
    set("SEED", seed);
    EXPECT_THROW(BoardSetup::from_environment(), BadArgument) << seed;
  }
}

Measured measured(Picoseconds time) {
  return {time, Counters({{"bus.down.bytes", "byte", 1000}, {"bus.down.busy_ps", "ps", time / 4}})};
}

TEST(TestCheck, IsTrueWithinItsToleranceAndFalseBeyond) {
  EXPECT_TRUE(time_is(measured(101), 100, 0.01));
  EXPECT_FALSE(time_is(measured(102), 100, 0.01).passed);
  EXPECT_FALSE(time_is(measured(98), 100, 0.01).passed);
  EXPECT_TRUE(counter_is(measured(1), "bus.down.bytes", 1000));
  EXPECT_FALSE(counter_is(measured(1), "bus.down.bytes", 1001).passed);
  EXPECT_TRUE(share_is(measured(4000), "bus.down.busy_ps", 0.25, 0));
  EXPECT_FALSE(share_is(measured(4000), "bus.down.busy_ps", 0.26, 0.01).passed);
  EXPECT_FALSE(near("nothing", 1, 0, 0.5).passed);
}

TEST(TestCheck, FailsForACounterThatTheBoardDoesNotKeep) {
  EXPECT_THAT(counter_is(measured(1), "no.such", 0).message, HasSubstr("no.such: this board has no such counter"));
  EXPECT_FALSE(share_is(measured(1), "no.such", 0, 1).passed);
}

TEST(TestCheck, SaysWhatWasExpectedAndWhatCame) {
  EXPECT_EQ(time_is(measured(35'200'000'000), 33.94e9, 0.01).message,
            "simulated time: expected 33.94 ms within 1%, got 35.2 ms (+3.712%)");
  EXPECT_EQ(counter_is(measured(1), "bus.down.bytes", 75'497'472).message,
            "bus.down.bytes: expected 75497472 exactly, got 1000 (-99.999%)");
}

TEST(TestCheck, GivesGoogleTestItsMessageAndThrowsItElsewhere) {
  const ::testing::AssertionResult result = near("ratio", 2, 1, 0.1);
  EXPECT_FALSE(result);
  EXPECT_STREQ(result.failure_message(), "ratio: expected 1 within 10%, got 2 (+100.000%)");
  EXPECT_NO_THROW(require(near("ratio", 1, 1, 0)));
  EXPECT_THROW(require(near("ratio", 2, 1, 0.1)), Failed);
}

TEST(TestWindow, MeasuresTimeAndCountersBetweenItsEnds) {
  Board board = BoardSetup{.bus = "agp2x"}.open();
  board.host_compute(1000);
  const Window window(board);
  board.host_compute(5'000'000);
  EXPECT_TRUE(time_is(window.end(), 5'000'000, 0));
  EXPECT_TRUE(counter_is(window.end(), "bus.down.bytes", 0));
  const std::vector<std::byte> samples(8, std::byte{100});
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {2, 2, 2}});
  EXPECT_GT(window.end().counters.value("bus.volume.bytes"), 0u);
  EXPECT_GT(window.end().per_second("bus.down.bytes"), 0);
}

}  // namespace
}  // namespace gicube::test
