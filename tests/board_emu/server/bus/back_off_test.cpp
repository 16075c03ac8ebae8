#include "server/bus/back_off.h"

#include "test.h"

namespace gicube::emu {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr BackOff::Clock::time_point kBegin{std::chrono::hours(1)};

TEST(BackOff, AllowsTheFirstAtOnce) {
  const BackOff back_off(seconds(2), seconds(60));
  EXPECT_TRUE(back_off.allows(kBegin));
  EXPECT_EQ(back_off.left(kBegin), milliseconds(0));
}

TEST(BackOff, DoublesThePauseUpToTheLongest) {
  BackOff back_off(seconds(2), seconds(10));
  auto now = kBegin;
  for (const seconds pause : {seconds(2), seconds(4), seconds(8), seconds(10), seconds(10)}) {
    back_off.happened(now);
    EXPECT_EQ(back_off.left(now), pause);
    EXPECT_FALSE(back_off.allows(now + pause - milliseconds(1)));
    now += pause;
    EXPECT_TRUE(back_off.allows(now));
  }
}

TEST(BackOff, BeginsAnewAfterARestOfTheLongestPause) {
  BackOff back_off(seconds(2), seconds(10));
  back_off.happened(kBegin);
  const auto rested = kBegin + seconds(2 + 10);
  BackOff early = back_off;
  early.happened(rested - milliseconds(1));
  EXPECT_EQ(early.left(rested - milliseconds(1)), seconds(4));
  back_off.happened(rested);
  EXPECT_EQ(back_off.left(rested), seconds(2));
}

}  // namespace
}  // namespace gicube::emu
