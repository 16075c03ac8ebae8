#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr int kProcessors[] = {1, 2, 4, 8, 16};
constexpr const char* kField = "asic.processors";

struct Machine {
  const char* name;
  Settings settings;
};

std::vector<Machine> machines() {
  const Settings skewed{{"asic.partition", "skewed_block"}};
  const auto with = [](Settings settings, const Settings& more) {
    settings.insert(more.begin(), more.end());
    return settings;
  };
  const Settings fast{{"dsp.clock_khz", "1600000"}};
  return {
      {"slab", {}},
      {"skewed", skewed},
      {"skewed, runs of 64 rays", with(skewed, {{"dsp.run_rays", "64"}})},
      {"skewed, DSP 8 times as fast", with(skewed, fast)},
      {"skewed, wide links, fast DSP, runs", with(with(skewed, fast), {{"dsp.run_rays", "64"}, {"link.bits", "256"}})}};
}

Run on(Run run, const Machine& machine, int processors) {
  for (const auto& [field, value] : machine.settings) run = run.with(field, value);
  return processors == 4 ? run : run.with(kField, processors);
}

double speed_up(Bench& bench, const Run& run, const Machine& machine, int processors) {
  return ratio(asic_ms(bench.get(on(run, machine, 1))), asic_ms(bench.get(on(run, machine, processors))));
}

std::string speed_up_reason(Bench& bench) {
  const auto lost = [&](std::size_t machine) {
    std::vector<Run> runs;
    for (const Run& run : bench.oblique()) runs.push_back(on(run, machines()[machine], 16));
    return lost_cycles(bench, runs);
  };
  return fmt::format(
      "of the cycles of 16 processors are without a sample, skewed: {}; with a fast DSP, runs and wide links: {}",
      lost(1), lost(4));
}

// Figure 16.
void fixed_problem(Bench& bench) {
  Page& page = bench.page();
  const int slabs = bench.design().edge / bench.design().block();
  Table table{"speed-up", {"machine", "processors"}, {}};
  Chart chart{"speed-up-chart",
              "Figure 16: speed-up of a fixed problem (mean of the scenes)",
              "processors",
              "speed-up",
              true,
              false,
              false,
              {"ideal"},
              {}};
  const std::vector<Run> runs = bench.oblique();
  for (const Run& run : runs) table.columns.push_back(name_of(run.scene));
  table.columns.insert(table.columns.end(), {"mean", "of ideal", "DSP busy"});
  for (const int p : kProcessors) chart.points.push_back({double(p), {double(p)}});
  std::vector<double> last;
  for (const Machine& machine : machines()) {
    chart.series.push_back(machine.name);
    for (std::size_t i = 0; i < std::size(kProcessors); ++i) {
      const int p = kProcessors[i];
      const bool possible = !machine.settings.empty() || p <= slabs;  // a slab is at least a block
      chart.points[i].second.push_back(std::numeric_limits<double>::quiet_NaN());
      if (!possible) continue;
      std::vector<double> ups, busy;
      std::vector<std::string> row{machine.name, std::to_string(p)};
      for (const Run& run : runs) {
        ups.push_back(speed_up(bench, run, machine, p));
        busy.push_back(dsp_use(bench.get(on(run, machine, p))));
        row.push_back(number(ups.back(), 2));
      }
      const double mean = spread_of(ups).mean;
      row.insert(row.end(), {number(mean, 2), percent(mean / p), percent(spread_of(busy).mean)});
      table.rows.push_back(row);
      chart.points[i].second.back() = mean;
    }
    last.push_back(chart.points.back().second.back());
  }
  page.text("The same volume and image with more processors. A slab is at least one block thick, so slabs end at " +
            std::to_string(slabs) + " processors.");
  page.table(table);
  page.chart(chart, "Speed-up against one processor of the same machine.");
  page.claim(
      {12, "speed-up at p = 16, 256^3 and 256^2 (5.2, Figure 16)", "within 14% of ideal: at least 13.8",
       fmt::format(
           "{:.1f}; {:.1f} with ray differentials; {:.1f} with a DSP 8 times as fast; {:.1f} with both and wide links",
           last[1], last[2], last[3], last[4]),
       differs(last[1], 13.8, 16), speed_up_reason(bench)});
}

// p processors, each with a box of half the design point's edge, and as many rays each.
Run grown(Bench& bench, SceneName scene, bool parallel, int processors) {
  const int half = bench.design().edge / 2;
  Run run = bench.run(scene, parallel ? ViewName::kAlongZ : ViewName::kOblique);
  run.dims = {processors >= 2 ? 2 * half : half, processors >= 4 ? 2 * half : half, processors >= 8 ? 2 * half : half};
  const int image = bench.design().image / 2;
  run.width = processors >= 2 ? 2 * image : image;
  run.height = processors >= 4 ? 2 * image : image;
  run.orthographic = parallel;
  run.picture = false;
  return processors == 4 ? run : run.with(kField, processors);
}

std::vector<Run> grown_runs(Bench& bench, int processors) {
  std::vector<Run> runs;
  for (const SceneName scene : {SceneName::kCloud, SceneName::kRock}) {
    for (const bool parallel : {true, false}) runs.push_back(grown(bench, scene, parallel, processors));
  }
  return runs;
}

void grown_problem(Bench& bench) {
  Table table{"grown", {"scene", "view", "p = 1", "2", "4", "8"}, {}};
  std::vector<double> first, last;
  for (const SceneName scene : {SceneName::kCloud, SceneName::kRock}) {
    for (const bool parallel : {true, false}) {
      std::vector<std::string> row{name_of(scene), parallel ? "along z, parallel rays" : "oblique"};
      for (const int p : {1, 2, 4, 8}) {
        const double busy = throughput(bench.get(grown(bench, scene, parallel, p)));
        row.push_back(percent(busy, 1));
        if (p == 1) first.push_back(busy);
        if (p == 8) last.push_back(busy);
      }
      table.rows.push_back(row);
    }
  }
  bench.page().text(fmt::format(
      "The problem grown with p: each processor has its {0}^3 voxels; the volume doubles along x, y, z for 2, 4, 8 "
      "processors, the image with its face, so that rays times their length grow as p. Throughput a processor, slabs.",
      bench.design().edge / 2));
  bench.page().table(table);
  const double one = spread_of(first).mean, eight = spread_of(last).mean;
  bench.page().claim({13, "throughput a processor, problem grown with p from 1 to 8 (5.2)", "99.9% to 80.7%",
                      fmt::format("{} to {}", percent(one, 1), percent(eight, 1)),
                      differs(one, 0.999, 0.999) || differs(eight, 0.807, 0.807),
                      fmt::format("cycles without a sample, one processor: {}; eight: {}",
                                  lost_cycles(bench, grown_runs(bench, 1)), lost_cycles(bench, grown_runs(bench, 8)))});
}

Run large(Bench& bench, SceneName scene, const char* partition, int image) {
  const int edge = 2 * bench.design().edge;
  Run run = bench.run(scene);
  run.dims = {edge, edge, edge};
  run.edge = edge;
  run.width = run.height = image;
  return run.with("asic.max_volume_voxels", edge).with(kField, 16).with("asic.partition", partition);
}

void large_problem(Bench& bench) {
  const int image = bench.design().image;
  Table table{"large",
              {"scene", "partition", fmt::format("{0}^2 image", image), fmt::format("{0}^2 image", 2 * image),
               "hit ratio", "hit ratio", "DSP busy", "DSP busy"},
              {}};
  std::vector<double> small, big;
  std::vector<Run> few_runs, many_runs;
  for (const SceneName scene : {SceneName::kBuckyball, SceneName::kHead, SceneName::kCloud}) {
    for (const char* partition : {"simple_slab", "skewed_block"}) {
      const Measurement &a = bench.get(large(bench, scene, partition, image)),
                        &b = bench.get(large(bench, scene, partition, 2 * image));
      table.rows.push_back({name_of(scene), partition, percent(throughput(a), 1), percent(throughput(b), 1),
                            percent(hit_ratio(a), 1), percent(hit_ratio(b), 1), percent(dsp_use(a)),
                            percent(dsp_use(b))});
      if (partition == std::string("skewed_block")) {
        small.push_back(throughput(a)), big.push_back(throughput(b));
        few_runs.push_back(large(bench, scene, partition, image));
        many_runs.push_back(large(bench, scene, partition, 2 * image));
      }
    }
  }
  bench.page().text(fmt::format("Throughput of 16 processors on {}^3 voxels.", 2 * bench.design().edge));
  bench.page().table(table);
  const double few = spread_of(small).mean, many = spread_of(big).mean;
  bench.page().claim({14, "512^3 with 16 processors: 256^2 image, 512^2 image (5.2)", "29.1%, 76.1%",
                      fmt::format("{}, {} (skewed)", percent(few, 1), percent(many, 1)),
                      differs(few, 0.291, 0.291) || differs(many, 0.761, 0.761),
                      fmt::format("cycles without a sample, small image: {}; large: {}", lost_cycles(bench, few_runs),
                                  lost_cycles(bench, many_runs))});
}

}  // namespace

void scaling_section(Bench& bench) {
  bench.page().heading("Scaling");
  fixed_problem(bench);
  grown_problem(bench);
  large_problem(bench);
}

}  // namespace gicube::samples::results
