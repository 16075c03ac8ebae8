#include <fmt/format.h>

#include <algorithm>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr double kPipeline = 32;      // rays that it holds [D Table 1]
constexpr double kPaperTail = 0.004;  // of the computation [P §5.1]

// From the first millisecond on after which none does half as many samples as the mean.
struct Tail {
  double time = 0, samples = 0, loads = 0;  // shares of all, 0..1
};

Tail tail_of(const std::vector<Millisecond>& list) {
  double samples = 0, loads = 0;
  for (const Millisecond& ms : list) samples += ms.samples, loads += ms.loads;
  const double half = 0.5 * ratio(samples, static_cast<double>(list.size()));
  auto first = list.end();
  while (first != list.begin() && std::prev(first)->samples < half) --first;
  Tail tail;
  for (auto at = first; at != list.end(); ++at) tail.samples += at->samples, tail.loads += at->loads;
  tail.time = ratio(static_cast<double>(list.end() - first), static_cast<double>(list.size()));
  tail.samples = ratio(tail.samples, samples);
  tail.loads = ratio(tail.loads, loads);
  return tail;
}

void time_chart(Bench& bench, SceneName scene) {
  const std::vector<Millisecond> list = milliseconds(bench.get(bench.light(scene)));
  Chart chart{"block-loads-" + name_of(scene),
              fmt::format("Figure 15: block loads in a lighting pass, {}", name_of(scene)), "ms", "in a millisecond"};
  chart.log_y = true;
  chart.series = {"block loads", "samples"};
  const auto or_none = [](double value) { return std::max(value, 1.0); };  // for the logarithm
  for (std::size_t ms = 0; ms < list.size(); ++ms) {
    chart.points.push_back({static_cast<double>(ms), {or_none(list[ms].loads), or_none(list[ms].samples)}});
  }
  bench.page().chart(chart, "A block load is a queue that becomes the active one.");
}

void stays_chart(Bench& bench) {
  Chart chart{"stays", "Turns by the length of their stay", "turns of a stay, at least", "share of all turns"};
  chart.log_x = true;
  std::vector<std::vector<Stay>> all;
  for (const SceneName scene : kLitScenes) {
    chart.series.push_back(name_of(scene));
    all.push_back(stays(bench.get(bench.light(scene))));
  }
  for (std::size_t i = 0; i < all.front().size(); ++i) {
    chart.points.push_back({all.front()[i].turns, {}});
    for (const auto& list : all) chart.points.back().second.push_back(list[i].issued);
  }
  bench.page().chart(chart, "Lighting passes, low albedo, k = 1.");
}

}  // namespace

void block_loads_section(Bench& bench) {
  Page& page = bench.page();
  page.heading("Block loads");
  time_chart(bench, SceneName::kMirrorBuckyball);
  time_chart(bench, SceneName::kFogBox);
  stays_chart(bench);
  Table table{"block-loads",
              {"scene", "part", "block loads", "turns a load", "turns in stays of 32 or more", "loads in short stays",
               "tail: share of time", "of samples", "of block loads"}};
  std::vector<double> tails, thrashing;
  for (const SceneName scene : kLitScenes) {
    for (const Run& run : {bench.light(scene), bench.lit(scene)}) {
      const Measurement& m = bench.get(run);
      const bool light = run.kind == Run::Kind::kLight;
      const double loads = static_cast<double>(m.counters.value("processor.sorter.activations"));
      double short_loads = 0;
      for (const Stay& stay : stays(m)) short_loads += stay.turns < kPipeline ? stay.activations : 0;
      const Tail tail = tail_of(milliseconds(m));
      table.rows.push_back({name_of(scene), light ? "pass" : "frame", number(loads, 0),
                            number(ratio(static_cast<double>(m.counters.value("processor.sorter.issued")), loads), 1),
                            percent(1 - issued_in_short_stays(m, kPipeline), 1), percent(short_loads, 1),
                            percent(tail.time, 1), percent(tail.samples, 2), percent(tail.loads, 1)});
      if (!light) continue;
      tails.push_back(tail.samples);
      thrashing.push_back(issued_in_short_stays(m, kPipeline));
    }
  }
  page.text(
      "Stays and turns as in the section before. Tail: the milliseconds at the end in none of which half as many "
      "samples are taken as in the mean one.");
  page.table(table);
  const Run pass = bench.light(SceneName::kMirrorBuckyball);
  const auto short_with = [&](const std::string& field, const std::string& value) {
    return percent(issued_in_short_stays(bench.get(pass.with(field, value)), kPipeline), 1);
  };
  const double tail = spread_of(tails).mean, shortly = spread_of(thrashing).mean;
  page.claim(
      {18, "block loads in global illumination (5.1, Figure 15)",
       "99.6% of the computation in long queues, 0.4% thrash",
       fmt::format("{} in stays of 32 turns or more, {} in short ones; the tail at the end holds {} of the samples",
                   percent(1 - shortly, 1), percent(shortly, 1), percent(tail, 2)),
       differs(shortly, kPaperTail, kPaperTail),
       fmt::format(
           "short stays come not only at the end: a processor that gets few rays, since the light comes from one side "
           "and the DSP makes one in 60 cycles, goes from queue to queue all the time. On the mirrored buckyball they "
           "hold {} of the turns; {} with skewed blocks, which spread the rays evenly, {} with 15 DSP cycles a ray, {} "
           "with queues of 1024 rays, {} with a pipeline of 4 compute stages. Lost cycles of all passes: {}",
           percent(issued_in_short_stays(bench.get(pass), kPipeline), 1), short_with("asic.partition", "skewed_block"),
           short_with("dsp.lighting_ray_cycles", "15"), short_with("asic.queue_rays", "1024"),
           short_with("pipeline.compute_stages", "4"), lost_cycles(bench, bench.lights()))});
}

}  // namespace gicube::samples::results
