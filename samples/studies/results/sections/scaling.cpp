#include <fmt/format.h>

#include <utility>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr const char* kField = "asic.processors";

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
  Table table{"grown", {"scene", "view", "p = 1", "2", "4", "8"}};
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

struct LargeMachine {
  const char* name;
  Settings settings;
  bool leap = true;
};

std::vector<LargeMachine> large_machines() {
  Settings fast = fast_front_end();
  fast["asic.partition"] = "skewed_block";
  return {{"slab", {}},
          {"skewed", {{"asic.partition", "skewed_block"}}},
          {"skewed, fast DSP, runs, wide links", fast},
          {"the same without leaps", fast, false}};
}

Run large(const Bench& bench, SceneName scene, const LargeMachine& machine, int image) {
  const int edge = 2 * bench.design().edge;
  Run run = bench.run(scene);
  run.dims = {edge, edge, edge};
  run.edge = edge;
  run.width = run.height = image;
  run.leap = machine.leap;
  run = run.with(machine.settings);
  return run.with("asic.max_volume_voxels", edge).with(kField, 16);
}

std::vector<Run> large_runs(const Bench& bench, const LargeMachine& machine, int image) {
  std::vector<Run> runs;
  for (const SceneName scene : {SceneName::kBuckyball, SceneName::kHead, SceneName::kCloud}) {
    runs.push_back(large(bench, scene, machine, image));
  }
  return runs;
}

void large_problem(Bench& bench) {
  const int image = bench.design().image;
  Table table{"large", {"machine", "scene"}};
  for (const int size : {image, 2 * image}) {
    const std::string of = fmt::format("{0}^2 image: ", size);
    table.columns.insert(table.columns.end(), {of + "throughput", "hit ratio", "DSP busy"});
  }
  for (const LargeMachine& machine : large_machines()) {
    const std::vector<Run> small = large_runs(bench, machine, image), big = large_runs(bench, machine, 2 * image);
    for (std::size_t i = 0; i < small.size(); ++i) {
      std::vector<std::string> row{machine.name, name_of(small[i].scene)};
      for (const Run& run : {small[i], big[i]}) {
        const Measurement& m = bench.get(run);
        row.insert(row.end(), {percent(throughput(m), 1), percent(hit_ratio(m), 1), percent(dsp_use(m))});
      }
      table.rows.push_back(row);
    }
  }
  bench.page().text(fmt::format("16 processors on {}^3 voxels, oblique views.", 2 * bench.design().edge));
  bench.page().table(table);

  const auto mean = [&](std::size_t machine, int size) {
    return bench.mean(large_runs(bench, large_machines()[machine], size), throughput);
  };
  const auto lost = [&](std::size_t machine) {
    return lost_cycles(bench, large_runs(bench, large_machines()[machine], 2 * image));
  };
  const double few = mean(1, image), many = mean(1, 2 * image);
  bench.page().claim(
      {14, "512^3 with 16 processors: 256^2 image, 512^2 image (5.2)", "29.1%, 76.1%",
       fmt::format("{}, {} (skewed); {}, {} with a fast DSP, runs and wide links", percent(few, 1), percent(many, 1),
                   percent(mean(2, image), 1), percent(mean(2, 2 * image), 1)),
       differs(few, 0.291, 0.291) || differs(many, 0.761, 0.761),
       fmt::format("the larger image is held up by the DSP, which at 28 cycles a ray is busy {} of the time, and by "
                   "links of 32 bits; then by leaping, after which the samples that are left lie unevenly: without it, "
                   "with a fast DSP, runs and wide links throughput is {} and {}. Cycles without a sample, {}^2 image: "
                   "{}; with a fast DSP, runs and wide links: {}; without leaps: {}",
                   percent(bench.mean(large_runs(bench, large_machines()[1], 2 * image), dsp_use)),
                   percent(mean(3, image), 1), percent(mean(3, 2 * image), 1), 2 * image, lost(1), lost(2), lost(3))});
}

}  // namespace

void scaling_section(Bench& bench) {
  grown_problem(bench);
  large_problem(bench);
}

}  // namespace gicube::samples::results
