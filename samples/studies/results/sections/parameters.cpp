#include <fmt/format.h>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr double kPaperThroughput = 231e6 / 400e6;  // [P §5.1]

struct Variant {
  std::string name;
  Settings settings;
};

std::vector<Variant> variants() {
  std::vector<Variant> list{{"design point", {}}};
  for (const auto& [prefetch, compute] : {std::pair(4, 28), {8, 24}, {24, 8}, {28, 4}, {16, 48}, {48, 16}}) {
    list.push_back({fmt::format("pipeline split {} + {}", prefetch, compute),
                    {{"pipeline.prefetch_stages", std::to_string(prefetch)},
                     {"pipeline.compute_stages", std::to_string(compute)}}});
  }
  for (const int packets : {8, 16, 64, 256}) {
    list.push_back(
        {fmt::format("{} packets asked for at a time", packets), {{"cache.miss_packets", std::to_string(packets)}}});
  }
  for (const int ways : {2, 4, 8})
    list.push_back({fmt::format("cache of {} ways", ways), {{"cache.ways", std::to_string(ways)}}});
  for (const int mhz : {50, 100, 400, 800})
    list.push_back({fmt::format("DSP of {} MHz", mhz), {{"dsp.clock_khz", std::to_string(1000 * mhz)}}});
  for (const int rays : {4, 16, 64, 256})
    list.push_back({fmt::format("runs of {} rays", rays), {{"dsp.run_rays", std::to_string(rays)}}});
  list.push_back({"queues by contribution", {{"sorter.policy", "most_contribution"}}});
  return list;
}

}  // namespace

void parameters_section(Bench& bench) {
  bench.page().heading("Free parameters");
  bench.page().text("What the paper leaves open, one at a time; oblique views, ASIC ms. Link width: above.");
  const SceneName scenes[] = {SceneName::kBuckyball, SceneName::kHead, SceneName::kRock};
  Table table{"parameters", {"variant"}};
  for (const SceneName scene : scenes) table.columns.push_back(name_of(scene));
  table.columns.insert(table.columns.end(),
                       {"throughput, mean", "hit ratio, mean", "memory GB/s, mean", "DSP busy, mean"});
  std::string far;
  for (const Variant& variant : variants()) {
    std::vector<Run> runs;
    for (const SceneName scene : scenes) {
      Run run = bench.run(scene).with(variant.settings);
      runs.push_back(run);
    }
    std::vector<std::string> row{variant.name};
    for (const Run& run : runs) row.push_back(number(asic_ms(bench.get(run)), 2));
    row.insert(row.end(), {percent(bench.mean(runs, throughput), 1), percent(bench.mean(runs, hit_ratio), 1),
                           number(bench.mean(runs, memory_gb_s), 2), percent(bench.mean(runs, dsp_use))});
    const double busy = bench.mean(runs, throughput);
    if (differs(busy, kPaperThroughput, kPaperThroughput))
      far += fmt::format("{}{} ({})", far.empty() ? "" : ", ", variant.name, percent(busy));
    table.rows.push_back(row);
  }
  bench.page().table(table);
  bench.page().text(
      fmt::format("The paper's 231 M samples/s of four pipelines at 100 MHz are a throughput of {}. Within a quarter "
                  "of it are all variants{}{}.",
                  percent(kPaperThroughput), far.empty() ? "" : " but ", far));
}

}  // namespace gicube::samples::results
