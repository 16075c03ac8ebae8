// The DSP's memory against hand-worked cases.
#include "../asic/dram/channels.h"

namespace gicube::emu::sdram {
namespace {

using dram::at;

v1::SdramConfig without_refresh() { return dram::without_refresh<dram::Sdram>(); }

// The command bus is free while a burst's data are on their way: ACT of bank 1 at 2 (tRRD), behind its RD at 6.
TEST(Sdram, OpensOneBankUnderTheDataOfAnother) {
  Channel channel(without_refresh(), 1);
  EXPECT_EQ(channel.read(at(0, 9), 0).data_begin, 4u);
  EXPECT_EQ(channel.read(at(1, 9), 0).data_begin, 8u);
}

// RD 102, data 104..107, WR 109 after a clock for the wires; RD 113 after its four beats, data 115.
TEST(Sdram, TurnsTheDataWiresRound) {
  Channel channel(without_refresh(), 1);
  channel.read(at(0, 9), 0);
  EXPECT_EQ(channel.read(at(0, 9, 1), 102).data_begin, 104u);
  EXPECT_EQ(channel.write(at(0, 9, 2), 102).data_begin, 109u);
  EXPECT_EQ(channel.read(at(0, 9, 3), 102).data_begin, 115u);
}

// WR 2, its last beat 5; PRE 6 by tWR, but 5 by tRAS; ACT 8, RD 10.
TEST(Sdram, AWriteHoldsItsRow) {
  Channel channel(without_refresh(), 1);
  channel.write(at(0, 9), 0);
  EXPECT_EQ(channel.read(at(0, 10), 0).data_begin, 12u);
}

TEST(Sdram, DataOfTwoRanksKeepAClockApart) {
  Channel channel(without_refresh(), 2);
  channel.read(at(0, 9), 0);
  channel.read(at(0, 9, 0, 1), 0);
  const Tcycle first = channel.read(at(0, 9, 1), 100).data_begin;
  EXPECT_EQ(channel.read(at(0, 9, 1, 1), 100).data_begin, first + 5);
}

// PRE 1562, REF 1564, ACT 1571, RD 1573.
TEST(Sdram, RefreshesARankEachIntervalWithItsRowsClosed) {
  Channel channel(v1::SdramConfig(), 1);
  channel.read(at(2, 7), 0);
  const Access access = channel.read(at(2, 7), 1562);
  EXPECT_EQ(access.data_begin, 1575u);
  EXPECT_EQ(access.cause, dram::Delay::kRefresh);
  channel.advance(1562 * 5);
  EXPECT_EQ(channel.counters().refreshes, 5u);
}

TEST(Sdram, SameBankAgainAndAgainTakesItsRowCycle) {
  Channel channel(without_refresh(), 1);
  Tcycle last = 0;
  for (unsigned row = 0; row < 50; ++row) {
    const Tcycle begin = channel.read(at(2, row), 0).data_begin;
    // tRCD + BL + tRP = 8 clocks are longer than tRC = 7.
    EXPECT_EQ(begin, row == 0 ? 4 : last + 8);
    last = begin;
  }
}

TEST(Sdram, GivesEveryBurstAPlaceAndASequenceOfPagesDifferentBanks) {
  EXPECT_EQ(locate(0), at(0, 0, 0));
  EXPECT_EQ(locate(31), at(0, 0, 0));
  EXPECT_EQ(locate(32), at(0, 0, 1));
  EXPECT_EQ(locate(4096), at(1, 0, 0));
  EXPECT_EQ(locate(4 * 4096), at(0, 1, 0));
  EXPECT_EQ(locate(sdram_map::kRankBytes), at(0, 0, 0, 1));
  EXPECT_EQ(locate(sdram_map::kRankBytes - 1), at(3, 4095, 127));
}

}  // namespace
}  // namespace gicube::emu::sdram
