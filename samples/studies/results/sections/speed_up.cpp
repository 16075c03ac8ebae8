#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr int kProcessors[] = {1, 2, 4, 8, 16};
constexpr int kMax = 16;

struct Machine {
  const char* name;
  Settings settings;
  bool ends_only = false;  // measured with one processor and with the most
};

enum Kind { kSlab, kSkewed, kRuns, kFastDsp, kFast, kSmallBlocks };

std::vector<Machine> machines(const Bench& bench) {
  const Settings skewed{{"asic.partition", "skewed_block"}};
  const auto with = [](Settings settings, const Settings& more) {
    for (const auto& [field, value] : more) settings[field] = value;
    return settings;
  };
  const Settings fast = with(skewed, fast_front_end());
  const std::string half = std::to_string(std::max(8, bench.design().block() / 2));
  return {{"slab", {}},
          {"skewed", skewed},
          {"skewed, runs of 64 rays", with(skewed, {{"dsp.run_rays", "64"}}), true},
          {"skewed, DSP 8 times as fast", with(skewed, {{"dsp.clock_khz", "1600000"}}), true},
          {"skewed, fast DSP, runs, wide links", fast},
          {"the same, blocks of half the edge", with(fast, {{"asic.block_voxels", half}})}};
}

Run on(Run run, const Machine& machine, int processors) {
  run = run.with(machine.settings);
  return processors == 4 ? run : run.with("asic.processors", processors);
}

std::vector<Run> on_all(const Bench& bench, const Machine& machine, int processors) {
  std::vector<Run> runs;
  for (const Run& run : bench.oblique()) runs.push_back(on(run, machine, processors));
  return runs;
}

std::vector<double> speed_ups(Bench& bench, const Machine& machine, int processors) {
  const std::vector<double> one = bench.over(on_all(bench, machine, 1), asic_ms),
                            many = bench.over(on_all(bench, machine, processors), asic_ms);
  std::vector<double> ups;
  for (std::size_t i = 0; i < one.size(); ++i) ups.push_back(ratio(one[i], many[i]));
  return ups;
}

double mean_speed_up(Bench& bench, Kind kind) { return spread_of(speed_ups(bench, machines(bench)[kind], kMax)).mean; }

double max_possible(Bench& bench, Kind kind) {
  return kMax * bench.mean(on_all(bench, machines(bench)[kind], kMax), work_balance);
}

bool measured(const Bench& bench, const Machine& machine, int processors) {
  const int slabs = bench.design().edge / bench.design().block();
  if (machine.settings.empty() && processors > slabs) return false;  // a slab is at least a block thick
  return !machine.ends_only || processors == 1 || processors == kMax;
}

void claim(Bench& bench) {
  const auto lost = [&](Kind kind) { return lost_cycles(bench, on_all(bench, machines(bench)[kind], kMax)); };
  const double plain = mean_speed_up(bench, kSkewed), best = mean_speed_up(bench, kSmallBlocks);
  bench.page().claim(
      {12, "speed-up at p = 16, 256^3 and 256^2 (5.2, Figure 16)", "within 14% of ideal: at least 13.8",
       fmt::format("{:.1f}; {:.1f} with ray differentials; {:.1f} with a DSP 8 times as fast; {:.1f} with both and "
                   "wide links; {:.1f} with blocks of half the edge besides",
                   plain, mean_speed_up(bench, kRuns), mean_speed_up(bench, kFastDsp), mean_speed_up(bench, kFast),
                   best),
       differs(plain, 13.8, 16),
       fmt::format(
           "two causes. The DSP makes and takes a ray in 28 of its cycles, which alone takes most of the frame of 16 "
           "processors (cycles without a sample: {}). And (i+j+k) mod 16 can't be even on an 8 x 8 x 8 grid of blocks "
           "(the paper itself asks that N be a multiple of p n): where the samples lie bounds the speed-up to {:.1f}. "
           "A 16 x 16 x 16 grid, which is even, is bound to {:.1f}; what is lost then is {}",
           lost(kSkewed), max_possible(bench, kFast), max_possible(bench, kSmallBlocks), lost(kSmallBlocks))});
}

}  // namespace

Settings fast_front_end() { return {{"dsp.clock_khz", "1600000"}, {"dsp.run_rays", "64"}, {"link.bits", "256"}}; }

void speed_up_section(Bench& bench) {
  Page& page = bench.page();
  page.heading("Scaling");
  Table table{"speed-up", {"machine", "processors"}};
  for (const SceneName scene : kScenes) table.columns.push_back(name_of(scene));
  table.columns.insert(table.columns.end(), {"mean", "of ideal", "bound by where the samples lie", "DSP busy"});
  Chart chart{"speed-up-chart", "Figure 16: speed-up of a fixed problem (mean of the scenes)", "processors",
              "speed-up"};
  chart.series = {"ideal"};
  for (const int p : kProcessors) chart.points.push_back({double(p), {double(p)}});
  for (const Machine& machine : machines(bench)) {
    chart.series.push_back(machine.name);
    for (std::size_t i = 0; i < std::size(kProcessors); ++i) {
      const int p = kProcessors[i];
      chart.points[i].second.push_back(std::numeric_limits<double>::quiet_NaN());
      if (!measured(bench, machine, p)) continue;
      const std::vector<double> ups = speed_ups(bench, machine, p);
      const double mean = spread_of(ups).mean;
      const std::vector<Run> runs = on_all(bench, machine, p);
      std::vector<std::string> row{machine.name, std::to_string(p)};
      for (const double up : ups) row.push_back(number(up, 2));
      row.insert(row.end(), {number(mean, 2), percent(mean / p), number(p * bench.mean(runs, work_balance), 2),
                             percent(bench.mean(runs, dsp_use))});
      table.rows.push_back(row);
      chart.points[i].second.back() = mean;
    }
  }
  page.text(
      "The same volume and image with more processors, against one processor of the same machine. Slabs are at least "
      "one block thick. Bound: p times the mean over the most samples that a processor has, which nothing but another "
      "partition can change.");
  page.table(table);
  page.chart(chart, "Oblique views.");
  claim(bench);
}

}  // namespace gicube::samples::results
