// What a card's energy is made of, against the currents of data sheets and sums by hand.
#include "config/energy.h"

#include "config/config.h"
#include "config/power_peaks.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr Picoseconds kMs = 1'000'000'000;

// One memory device: a volume of 32^3 voxels.
v1::BoardConfig small(const std::vector<std::string>& fields = {}) {
  v1::BoardConfig config;
  for (const char* field : {"fidelity=cycle", "asic.processors=1", "asic.max_volume_voxels=32"}) {
    EXPECT_THAT(apply_override(config, field), IsEmpty());
  }
  for (const std::string& field : fields) EXPECT_THAT(apply_override(config, field), IsEmpty()) << field;
  return resolve(config);
}

// Watts of a part over a millisecond in which this was counted.
double watts(const v1::BoardConfig& config, const std::string& part,
             const std::map<std::string, std::uint64_t>& counted) {
  std::vector<wire::Counter> counters;
  for (const auto& [name, value] : counted) counters.push_back({name, "", value});
  for (const PartEnergy& each : EnergyModel(config).parts(counters, kMs)) {
    if (part == each.part) return static_cast<double>(each.pj) * 1e-12 / 1e-3;
  }
  ADD_FAILURE() << part;
  return 0;
}

// Samsung K4R271669F: a device reads 1.20 W with a row for each two packets, a packet every four clocks; writes 1.25 W;
// standby 0.19 W, which its refresh current is too.
TEST(Energy, OfAnRdramIsThatOfItsDataSheet) {
  static constexpr std::uint64_t kClocks = 400'000;  // of 2.5 ns in a millisecond
  const auto busy = [](const char* what) {
    return std::map<std::string, std::uint64_t>{
        {"rdram.data_busy", kClocks}, {"rdram.activates", kClocks / 8}, {what, kClocks / 4}};
  };
  const auto without_refresh = small({"rdram.refresh_interval=0"});
  EXPECT_NEAR(watts(without_refresh, "memory", busy("rdram.reads")), 1.20, 0.02 * 1.20);
  EXPECT_NEAR(watts(without_refresh, "memory", busy("rdram.writes")), 1.25, 0.02 * 1.25);
  EXPECT_NEAR(watts(without_refresh, "memory", {}), 0.1875, 0.02 * 0.19);
  EXPECT_NEAR(watts(small(), "memory", {}), 0.1875, 0.02 * 0.19);
  EXPECT_NEAR(watts(small({"energy.rdram_standby_uw=12500", "rdram.refresh_interval=0"}), "memory", {}), 0.0125,
              0.0003);
}

// Infineon HYS72D64000GU-7 at its 133 MHz, 2.5 V: IDD4R 1800 mA, IDD4W 1755 mA, IDD3N 630 mA, and IDD0 1530 mA with a
// row each 65 ns, which is in precharge standby for a part of that.
TEST(Energy, OfADdrRankIsThatOfItsDataSheet) {
  const auto config = small({"memory=ddr", "ddr.clock_khz=133333", "ddr.refresh_interval=0"});
  constexpr std::uint64_t kClocks = 133'333;
  EXPECT_NEAR(watts(config, "memory", {{"ddr.reads", kClocks}}), 2.5 * 1.800, 0.02 * 4.5);
  EXPECT_NEAR(watts(config, "memory", {{"ddr.writes", kClocks}}), 2.5 * 1.755, 0.02 * 4.4);
  EXPECT_NEAR(watts(config, "memory", {}), 2.5 * 0.630, 0.02 * 1.6);
  EXPECT_NEAR(watts(config, "memory", {{"ddr.activates", 1'000'000 / 65}}), 2.5 * 1.530, 0.05 * 3.8);
  // Hynix HYMD512M646B, page 6: IDD5 2360 mA of two ranks of eight chips, of which one rests at 300 mA; refresh each
  // 75 ns.
  const auto refresh = small({"memory=ddr", "ddr.clock_khz=133333", "ddr.refresh_interval=10"});
  EXPECT_NEAR(watts(refresh, "memory", {}), 2.5 * (2.360 - 0.300) * 9 / 8, 0.02 * 5.8);
  // IDD2P of Infineon's module: 126 mA.
  const auto power_down =
      small({"memory=ddr", "ddr.clock_khz=133333", "ddr.refresh_interval=0", "energy.ddr_rank_uw=315000"});
  EXPECT_NEAR(watts(power_down, "memory", {}), 2.5 * 0.126, 0.001);
}

// Eight Samsung K4S560832D-1H, 3.3 V: ICC4 100 mA, ICC2N 20 mA, ICC1 90 mA with a row and a read each 70 ns. Their I/O
// is outside.
TEST(Energy, OfAnSdramRankIsThatOfItsDataSheet) {
  const auto config =
      small({"sdram.ranks=3", "dsp.framebuffer_mb=1", "energy.sdram_io_fj=0", "sdram.refresh_interval=0"});
  const double others = 2 * 8 * 3.3 * 0.020;
  EXPECT_NEAR(watts(config, "sdram", {}), others + 8 * 3.3 * 0.020, 0.01);
  EXPECT_NEAR(watts(config, "sdram", {{"sdram.reads", 25'000}}), others + 8 * 3.3 * 0.100, 0.02 * 2.6);
  const std::uint64_t rows = 1'000'000 / 70;  // each with a burst of one word, a quarter of a packet
  EXPECT_NEAR(watts(config, "sdram", {{"sdram.row_misses", rows}, {"sdram.reads", rows / 4}}), others + 8 * 3.3 * 0.090,
              0.02 * 2.4);
  // ICC5 190 mA, refresh each 70 ns; ICC2P 2 mA.
  const auto refresh = small({"sdram.ranks=3", "dsp.framebuffer_mb=1", "sdram.refresh_interval=7"});
  EXPECT_NEAR(watts(refresh, "sdram", {}), 3 * 8 * 3.3 * 0.190, 0.02 * 15);
  const auto power_down =
      small({"sdram.ranks=3", "dsp.framebuffer_mb=1", "sdram.refresh_interval=0", "energy.sdram_rank_uw=52800"});
  EXPECT_NEAR(watts(power_down, "sdram", {}), 3 * 8 * 3.3 * 0.002, 0.001);
}

TEST(Energy, OfTheDspIsThatOfItsTimeAtWork) {
  const auto config = small();
  EXPECT_NEAR(watts(config, "dsp", {{"dsp.busy_ps", kMs}}), 1.34, 0.001);  // SPRA486C: 1.3 W at 200 MHz
  EXPECT_NEAR(watts(config, "dsp", {}), 0.9, 0.001);
  EXPECT_NEAR(watts(small({"dsp.clock_khz=100000"}), "dsp", {{"dsp.busy_ps", kMs / 2}}), (0.67 + 0.45) / 2, 0.001);
}

TEST(Energy, IsProportionalToEventsAndPrices) {
  const auto of = [](const std::vector<std::string>& fields, const char* part, const char* event) {
    return watts(small(fields), part, {{event, 2'000'000}}) - watts(small(fields), part, {{event, 1'000'000}});
  };
  for (const auto& [part, event, field] :
       std::vector<std::array<const char*, 3>>{{"queues", "processor.sorter.written", "edram_bit_fj"},
                                               {"cache", "processor.cache.packets", "sram_bit_fj"},
                                               {"tables", "processor.samples", "sram_bit_fj"},
                                               {"pipelines", "processor.samples", "logic_aj"},
                                               {"pipelines", "processor.splat.deposits", "logic_aj"},
                                               {"sorters", "processor.sorter.inserts", "logic_aj"},
                                               {"links", "link.busy", "link_bit_fj"},
                                               {"ray_bus", "dsp.rays_sent", "ray_bus_bit_fj"},
                                               {"host_bus", "bus.up.bytes", "pci_byte_fj"}}) {
    const double usual = of({}, part, event);
    EXPECT_GT(usual, 0) << event;
    const auto number =
        std::to_string(2 * small().energy().GetReflection()->GetUInt32(
                               small().energy(), v1::EnergyConfig::descriptor()->FindFieldByName(field)));
    EXPECT_NEAR(of({std::string("energy.") + field + "=" + number}, part, event), 2 * usual, 1e-6 * usual) << event;
  }
}

TEST(Energy, HasItsUncertaintyAndItsSum) {
  std::vector<wire::Counter> counters{{"rdram.reads", "packet", 1000}, {"processor.samples", "sample", 5000}};
  EnergyModel(small()).count(counters, kMs);
  std::map<std::string, std::uint64_t> value;
  for (const wire::Counter& each : counters) value[each.name] = each.value;
  std::uint64_t sum = 0;
  for (const auto& [name, pj] : value) {
    if (!name.starts_with("energy.") || name.ends_with(".low") || name.ends_with(".high")) continue;
    EXPECT_LE(value.at(name + ".low"), pj) << name;
    EXPECT_GE(value.at(name + ".high"), pj) << name;
    if (name != "energy.total") sum += pj;
  }
  EXPECT_EQ(value.at("energy.total"), sum);
  EXPECT_EQ(value.at("energy.dsp.low"), value.at("energy.dsp") * 60 / 100);  // idle: 40%
}

TEST(Energy, PeaksAreThoseOfTheHighestWindowSinceTheyWereAskedFor) {
  const v1::BoardConfig config = small();
  const EnergyModel model(config);
  PowerPeaks peaks(model, config.asic().core_khz());
  const auto at = [](std::uint64_t cycles, std::uint64_t samples) {
    return std::vector<wire::Counter>{{"asic.cycles", "", cycles}, {"processor.samples", "", samples}};
  };
  const auto microwatts = [&peaks] {
    std::vector<wire::Counter> counters;
    peaks.count(counters);
    std::map<std::string, std::uint64_t> value;
    for (const wire::Counter& each : counters) value[each.name] = each.value;
    return value;
  };
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(peaks.is_due());
  EXPECT_TRUE(microwatts().empty());
  peaks.ask(at(100'000, 900'000));
  int reports = 1;
  while (!peaks.is_due()) ++reports;
  EXPECT_EQ(reports, 49);  // of 4096 cycles: two milliseconds at 100 MHz
  peaks.see(at(300'000, 901'000));
  peaks.see(at(400'000, 999'000));  // half a window is none
  peaks.see(at(500'000, 1'001'000));
  peaks.see(at(700'000, 1'001'000));
  const auto energy = [&model](std::uint64_t samples, std::size_t part) {
    return model.parts({{"processor.samples", "", samples}, {"pipeline.visible_samples", "", samples}}, 2 * kMs)
        .at(part);
  };
  const std::map<std::string, std::uint64_t> found = microwatts();
  EXPECT_EQ(found.count("energy.host_bus.peak"), 0u);
  std::uint64_t low = 0, value = 0, high = 0;
  for (std::size_t part = 0; part < model.parts({}, kMs).size() - 1; ++part) {
    const PartEnergy each = energy(100'000, part);
    const double uw = static_cast<double>(each.pj) * 0.5e-3;
    EXPECT_NEAR(static_cast<double>(found.at(std::string("energy.") + each.part + ".peak")), uw, 1e-4 * uw + 1)
        << each.part;
    low += each.low_pj / 2000, value += each.pj / 2000, high += each.high_pj / 2000;
  }
  EXPECT_NEAR(static_cast<double>(found.at("energy.total.peak_low")), static_cast<double>(low), 1e-4 * 1e7);
  EXPECT_NEAR(static_cast<double>(found.at("energy.total.peak")), static_cast<double>(value), 1e-4 * 1e7);
  EXPECT_NEAR(static_cast<double>(found.at("energy.total.peak_high")), static_cast<double>(high), 1e-4 * 1e7);
}

TEST(Energy, IsNoneAtTheFunctionalLevel) {
  std::vector<wire::Counter> counters{{"pipeline.samples", "sample", 5}};
  EnergyModel(small({"fidelity=functional"})).count(counters, kMs);
  EXPECT_EQ(counters.size(), 1u);
}

}  // namespace
}  // namespace gicube::emu
