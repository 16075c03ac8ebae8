#include "render/statistics.h"

#include "gicube/scene/error.h"
#include "scene/names.h"
#include "test.h"

namespace gicube::samples {
namespace {

FrameStatistics example() {
  FrameStatistics statistics;
  statistics.board.config_hash = 0xab;
  statistics.counters = Counters({{"bus.down.busy_ps", "ps", 1'000'000'000},
                                  {"bus.up.busy_ps", "ps", 500'000'000},
                                  {"pipeline.samples", "1", 12345}});
  statistics.frame = 4'000'000'000;
  statistics.load = 9'000'000'000;
  statistics.host_seconds = 0.25;
  statistics.width = 64;
  statistics.height = 32;
  statistics.dims = {10, 20, 30};
  statistics.seed = 5;
  return statistics;
}

TEST(Statistics, HoldTheFrameInSimulatedTimeAndCounters) {
  const auto json = to_json(example());
  EXPECT_DOUBLE_EQ(json.at("frame_ms"), 4);
  EXPECT_DOUBLE_EQ(json.at("load_ms"), 9);
  EXPECT_DOUBLE_EQ(json.at("bus_ms"), 1.5);
  EXPECT_DOUBLE_EQ(json.at("host_seconds"), 0.25);
  EXPECT_EQ(json.at("samples"), 12345);
  EXPECT_EQ(json.at("config_hash"), "00000000000000ab");
  EXPECT_EQ(json.at("fidelity"), "functional");
  EXPECT_EQ(json.at("seed"), 5);
  EXPECT_EQ(json.at("image").at("width"), 64);
  EXPECT_EQ(json.at("volume").at("dims"), nlohmann::json({10, 20, 30}));
  EXPECT_EQ(json.at("counters").at("bus.up.busy_ps").at("value"), 500'000'000);
  EXPECT_EQ(json.at("counters").at("bus.up.busy_ps").at("unit"), "ps");
}

TEST(Statistics, HaveNullForWhatTheLevelDoesNotModel) {
  const auto json = to_json(example());
  for (const char* key : {"samples_per_second", "throughput", "hit_ratio", "memory_gb_s", "memory_utilisation"}) {
    EXPECT_TRUE(json.at(key).is_null()) << key;
  }
  FrameStatistics silent = example();
  silent.counters = Counters();
  EXPECT_TRUE(to_json(silent).at("samples").is_null());
}

TEST(Statistics, SayWhatTheAsicDidWhereItsPartsTakeTime) {
  FrameStatistics statistics = example();
  statistics.board.fidelity = Fidelity::kCycle;
  statistics.board.processors = 4;
  statistics.board.core_khz = 100'000;
  statistics.counters = Counters({{"asic.cycles", "cycle", 100'000},  // 1 ms
                                  {"processor.samples", "sample", 300'000},
                                  {"processor.cache.checks", "sample", 300'000},
                                  {"processor.cache.missed_voxels", "voxel", 240'000},
                                  {"processor.rays_held", "cycle", 320'000},
                                  {"dsp.busy_ps", "ps", 250'000'000},
                                  {"rdram.reads", "packet", 100'000},
                                  {"rdram.writes", "packet", 50'000},
                                  {"rdram.data_busy", "tCYCLE", 600'000},
                                  {"rdram.cycles", "tCYCLE", 1'600'000}});
  const auto json = to_json(statistics);
  EXPECT_DOUBLE_EQ(json.at("samples_per_second"), 300e6);
  EXPECT_DOUBLE_EQ(json.at("throughput"), 0.75);
  EXPECT_DOUBLE_EQ(json.at("hit_ratio"), 0.9);
  EXPECT_DOUBLE_EQ(json.at("memory_gb_s"), 2.4);
  EXPECT_DOUBLE_EQ(json.at("memory_utilisation"), 0.375);
  EXPECT_DOUBLE_EQ(json.at("load_balance"), 0.8);
  EXPECT_DOUBLE_EQ(json.at("dsp_utilisation"), 0.25);
}

TEST(Statistics, TellWhereTheLightWentAndWhetherAPassWasMadeAnew) {
  EXPECT_TRUE(to_json(example()).at("lighting").is_null());
  FrameStatistics statistics = example();
  LightingStatistics red;
  red.channel = "red";
  red.settings.albedo = Albedo::kHigh;
  red.report = {100, 10, 4, 3, {0, 0, 0, 0, 2, 1}, 2, 1, 1, 0.01, {"a light stands in a solid"}};
  red.duration = 5'000'000'000;
  red.reused = true;
  statistics.lighting = {red};
  const auto json = to_json(statistics).at("lighting").at(0);
  EXPECT_EQ(json.at("channel"), "red");
  EXPECT_EQ(json.at("albedo"), "high");
  EXPECT_EQ(json.at("rules"), "conserving");
  EXPECT_EQ(json.at("reused"), true);
  EXPECT_DOUBLE_EQ(json.at("pass_ms"), 5);
  EXPECT_EQ(json.at("rays"), 100);
  const double parts = json.at("deposited").get<double>() + json.at("escaped").get<double>() +
                       json.at("scattered_away").get<double>() + json.at("clipped").get<double>();
  EXPECT_DOUBLE_EQ(json.at("emitted"), parts);
  EXPECT_EQ(json.at("escaped_by_face").at("y_max"), 0);
  EXPECT_EQ(json.at("escaped_by_face").at("z_min"), 2);
  EXPECT_EQ(json.at("escaped_by_face").at("z_max"), 1);
  EXPECT_EQ(json.at("warnings").at(0), "a light stands in a solid");
  EXPECT_TRUE(json.at("colours").is_null());
  statistics.lighting[0].report.colours = {{1, 2, 3, 4, 5, 6}, {}, {.escaped = 7}};
  const auto colours = to_json(statistics).at("lighting").at(0).at("colours");
  EXPECT_EQ(colours.at("red").at("clipped"), 6);
  EXPECT_EQ(colours.at("blue").at("escaped"), 7);
}

// A pass at the cycle level and two pictures at the functional one: what the first leaves out belongs to the run.
TEST(Statistics, ReportTheFidelityOfTheLightToo) {
  FrameStatistics first = example();
  first.counters =
      Counters({{"fidelity_answered.functional", "command", 1}, {"fidelity_answered.functional.render", "command", 1}});
  FrameStatistics second = first;
  first.lighting.resize(1);
  first.lighting[0].counters =
      Counters({{"fidelity_answered.cycle", "command", 3}, {"fidelity_answered.cycle.illuminate", "command", 3}});
  second.lighting = first.lighting;
  second.lighting[0].reused = true;
  const auto report = to_json(first).at("fidelity_report");
  ASSERT_EQ(report.size(), 2u);
  EXPECT_EQ(report.at(0).at("answered"), nlohmann::json({{"render", 1}}));
  EXPECT_EQ(report.at(1).at("level"), "cycle");
  EXPECT_EQ(report.at(1).at("answered"), nlohmann::json({{"illuminate", 3}}));
  EXPECT_EQ(to_json(second).at("fidelity_report").size(), 1u);
  const std::string path = testing::TempDir() + "/fidelity.json";
  write_statistics({first, second}, path);
  std::ifstream stream(path);
  const auto both = nlohmann::json::parse(stream).at("fidelity_report");
  EXPECT_EQ(both.at(0).at("answered"), nlohmann::json({{"render", 2}}));
  EXPECT_EQ(both.at(1).at("answered"), nlohmann::json({{"illuminate", 3}}));
}

TEST(Statistics, SayWhatTheRunCostItsComputer) {
  EXPECT_TRUE(to_json(example()).at("host").is_null());
  FrameStatistics statistics = example();
  statistics.host = RunUsage{.program = {.cpu_seconds = 2, .peak_mib = 30}, .boards = HostUsage{4, 50}};
  const auto host = to_json(statistics).at("host");
  EXPECT_EQ(host.at("program_cpu_s"), 2);
  EXPECT_EQ(host.at("program_peak_mib"), 30);
  EXPECT_EQ(host.at("board_cpu_s"), 4);
  EXPECT_EQ(host.at("board_peak_mib"), 50);
  statistics.host->boards.reset();
  EXPECT_TRUE(to_json(statistics).at("host").at("board_peak_mib").is_null());
}

TEST(Statistics, OfAnAnimationCountThePassesThatWereMade) {
  FrameStatistics first = example(), second = example();
  first.lighting.resize(1);
  second.lighting.resize(1);
  second.lighting[0].reused = true;
  second.load = 0;
  second.time = 0.5;
  const std::string path = testing::TempDir() + "/animation.json";
  write_statistics({first, second, second}, path);
  std::ifstream stream(path);
  const auto json = nlohmann::json::parse(stream);
  EXPECT_EQ(json.at("illumination_passes"), 1);
  EXPECT_EQ(json.at("volumes_loaded"), 1);
  ASSERT_EQ(json.at("frames").size(), 3u);
  EXPECT_EQ(json.at("frames").at(2).at("time"), 0.5);
  EXPECT_FALSE(json.at("frames").at(0).contains("counters"));
}

TEST(Statistics, SayWhenTheFileCannotBeWritten) {
  EXPECT_THROW(write_statistics(example(), "/nowhere/stats.json"), InputError);
}

}  // namespace
}  // namespace gicube::samples
