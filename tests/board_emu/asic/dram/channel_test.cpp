// The properties that the channels of all memory standards share, each with its times.
#include "channels.h"
#include "long_times.h"

namespace gicube::emu::dram {
namespace {

template <typename Standard>
class DramChannel : public testing::Test {
 protected:
  using Channel = typename Standard::Channel;
  using Config = typename Standard::Config;

  Channel channel_{without_refresh<Standard>(), 1};
};

struct NameOfStandard {
  template <typename Standard>
  static std::string GetName(int) {
    return Standard::kName;
  }
};

using Standards = testing::Types<Ddr, Sdram, Rdram>;
TYPED_TEST_SUITE(DramChannel, Standards, NameOfStandard);

TYPED_TEST(DramChannel, AColdReadActivatesItsRow) {
  const Access access = this->channel_.read(at(3, 9), 1000);
  EXPECT_EQ(access.data_begin, 1000u + TypeParam::kColdRead);
  EXPECT_EQ(access.data_end, access.data_begin + TypeParam::kBurst);
  EXPECT_EQ(access.cause, Delay::kTransfer);
}

TYPED_TEST(DramChannel, AColdWriteActivatesItsRow) {
  EXPECT_EQ(this->channel_.write(at(3, 9), 1000).data_begin, 1000u + TypeParam::kColdWrite);
}

TYPED_TEST(DramChannel, AnOpenRowNeedsNoActivation) {
  this->channel_.read(at(3, 9), 0);
  EXPECT_EQ(this->channel_.read(at(3, 9, 1), 1000).data_begin, 1000u + TypeParam::kOpenRow);
  EXPECT_EQ(this->channel_.counters().row_hits, 1u);
}

TYPED_TEST(DramChannel, OtherRowOfAnOpenBankTakesAPrechargeMore) {
  this->channel_.read(at(3, 9), 0);
  const Access access = this->channel_.read(at(3, 10), 1000);
  EXPECT_EQ(access.data_begin, 1000u + TypeParam::kOtherRow);
  EXPECT_EQ(access.cause, Delay::kBank);
  EXPECT_EQ(this->channel_.counters().conflicts, 1u);
}

TYPED_TEST(DramChannel, QueuedPacketsOfOpenRowsFollowOneAnother) {
  const Tcycle first = this->channel_.read(at(3, 9), 0).data_begin;
  for (const unsigned next : {1u, 2u}) {
    const Access access = this->channel_.read(at(3, 9, next), 0);
    EXPECT_EQ(access.data_begin, first + next * TypeParam::kBurst);
    EXPECT_EQ(access.cause, Delay::kTransfer);
  }
}

TYPED_TEST(DramChannel, CallingOrderIsServiceOrder) {
  this->channel_.read(at(3, 9), 0);
  const Access slow = this->channel_.read(at(3, 10), 0);
  EXPECT_EQ(this->channel_.read(at(3, 10, 1), 0).data_begin, slow.data_end);
  EXPECT_GT(this->channel_.read(at(1, 1), 0).data_begin, slow.data_end);
}

TYPED_TEST(DramChannel, SameCallsGiveTheSameTimesWithOrWithoutATrace) {
  std::vector<IssuedCommand> trace;
  typename TypeParam::Channel a(typename TypeParam::Config(), 2), b(typename TypeParam::Config(), 2);
  b.set_trace(&trace);
  EXPECT_EQ(random_traffic<TypeParam>(a, 2, 5000, 1), random_traffic<TypeParam>(b, 2, 5000, 1));
  EXPECT_EQ(a.counters(), b.counters());
  const ChannelCounters counters = a.counters();
  EXPECT_EQ(trace.size(), counters.packets_read + counters.packets_written + counters.activates + counters.precharges +
                              counters.refreshes);
}

TYPED_TEST(DramChannel, CountsWhatItDid) {
  this->channel_.read(at(2, 1), 0);      // miss
  this->channel_.read(at(2, 1, 5), 0);   // hit
  this->channel_.write(at(2, 2), 0);     // conflict
  this->channel_.write(at(0, 2), 1000);  // miss
  const ChannelCounters expected{2, 2, 1, 3, 1, 3, 1, 0, 4 * TypeParam::kBurst, 0};
  EXPECT_EQ(this->channel_.counters(), expected);
}

TYPED_TEST(DramChannel, RefusesToBeEmpty) {
  EXPECT_THROW(typename TypeParam::Channel(typename TypeParam::Config(), 0), std::invalid_argument);
}

TYPED_TEST(DramChannel, IsRefreshedInEachIntervalDeviceByDevice) {
  for (const unsigned devices : {1u, 2u}) {
    std::vector<IssuedCommand> trace;
    typename TypeParam::Channel channel(typename TypeParam::Config(), devices);
    channel.set_trace(&trace);
    channel.advance(Tcycle{TypeParam::kRefresh} * 70);
    std::erase_if(trace, [](const IssuedCommand& each) { return each.command != Command::kRefresh; });
    ASSERT_EQ(trace.size(), 70u * devices);
    for (std::size_t i = 0; i < trace.size(); ++i) {
      EXPECT_EQ(trace[i].device, i % devices);
      EXPECT_EQ(trace[i].begin, TypeParam::kRefresh * (i + 1) / devices);
    }
    EXPECT_EQ(channel.counters().refreshes, trace.size());
  }
}

TYPED_TEST(DramChannel, IsNotRefreshedIfThatIsSwitchedOff) {
  this->channel_.advance(1'000'000);
  EXPECT_EQ(this->channel_.counters().refreshes, 0u);
}

TYPED_TEST(DramChannel, RefreshesOfALongTimeAtOnceAreThoseOfItsParts) {
  for (const unsigned devices : TypeParam::kDevices) {
    for (const unsigned interval : {64u, 100u, TypeParam::kRefresh, 5000u}) {
      if (interval < 64 * devices) continue;  // none are left out
      typename TypeParam::Config config;
      config.set_refresh_interval(interval);
      expect_long_times_to_be_short_ones(
          [&] { return std::make_unique<typename TypeParam::Channel>(config, devices); }, devices, interval,
          [&](std::mt19937& random) {
            const auto below = [&](unsigned limit) { return static_cast<unsigned>(random() % limit); };
            return at(below(TypeParam::kBanks), below(3), below(64), below(devices));
          });
    }
  }
}

// Whole traces against the independent checker; `tight`: the least share of commands that are.
template <typename Standard>
void expect_legal_traffic(const typename Standard::Config& config, typename Standard::CheckedRules rules,
                          unsigned devices, int packets, unsigned seed, double tight) {
  std::vector<IssuedCommand> trace;
  typename Standard::Channel channel(config, devices);
  channel.set_trace(&trace);
  const std::vector<Tcycle> begins = random_traffic<Standard>(channel, devices, packets, seed);
  rules.devices = devices;
  const auto verdict = reference::check_trace(rules, trace);
  EXPECT_THAT(verdict.faults, IsEmpty()) << devices << " devices, seed " << seed;
  EXPECT_EQ(verdict.data_begins, begins) << "data do not come when the controller said";
  EXPECT_GT(static_cast<double>(verdict.tight_commands), tight * static_cast<double>(trace.size()));
  const ChannelCounters counters = channel.counters();
  EXPECT_GT(counters.refreshes, 100u);
  EXPECT_GT(counters.row_hits, 1000u);
  EXPECT_GT(counters.conflicts, 1000u);
}

TYPED_TEST(DramChannel, ATraceOfRandomTrafficBreaksNoRuleAndIsTight) {
  for (const unsigned devices : TypeParam::kDevices) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      expect_legal_traffic<TypeParam>({}, TypeParam::kRules, devices, 20'000, seed, 0.9);
    }
  }
}

TYPED_TEST(DramChannel, ATraceFollowsTheConfiguration) {
  typename TypeParam::Config config;
  auto rules = TypeParam::set_other_times(config);
  rules.refresh_interval = 500;
  expect_legal_traffic<TypeParam>(config, rules, 2, 20'000, 9, 0.89);
}

}  // namespace
}  // namespace gicube::emu::dram
