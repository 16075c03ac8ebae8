#include <fmt/format.h>

#include <cmath>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr double kSteps[] = {2, 1, 0.5, 0.25, 0.125};  // voxels

Run at_image(Run run, int image) {
  run.picture = run.picture && image == run.width;
  run.width = run.height = image;
  return run;
}

void histogram(Bench& bench, SceneName scene) {
  Chart chart{"misses-" + name_of(scene), "Figure 9: misses a sample, " + name_of(scene), "misses of a sample",
              "share of samples"};
  chart.bars = true;
  for (int misses = 0; misses <= 8; ++misses) chart.points.push_back({double(misses), {}});
  for (const double step : kSteps) {
    chart.series.push_back(fmt::format("step {:g}", step));
    const std::vector<double> shares = miss_histogram(bench.get(bench.run(scene).at_step(step)));
    for (std::size_t i = 0; i < shares.size(); ++i) chart.points[i].second.push_back(shares[i]);
  }
  bench.page().chart(chart, "By distance of the samples in voxels.");
}

void steps(Bench& bench) {
  Table table{"steps", {"step, voxels"}};
  for (const SceneName scene : kScenes) {
    for (const char* column : {"misses a sample", "memory GB/s", "memory in use", "throughput", "Hz"})
      table.columns.push_back(name_of(scene) + ": " + column);
  }
  const auto add = [&](const std::string& name, double step, bool jitter) {
    std::vector<std::string> row{name};
    for (const SceneName scene : kScenes) {
      Run run = bench.run(scene).at_step(step);
      run.jitter = jitter;
      run.picture = run.picture && !jitter;
      const Measurement& m = bench.get(run);
      row.insert(row.end(), {number(misses_a_sample(m), 2), number(memory_gb_s(m), 2), percent(memory_use(m)),
                             percent(throughput(m)), number(rate_hz(m))});
    }
    table.rows.push_back(row);
  };
  for (const double step : kSteps) add(fmt::format("{:g}", step), step, false);
  add("1, jittered", 1, true);
  bench.page().text("Jitter shortens each step by a random factor of 1/2 to 1, as the paper does.");
  bench.page().table(table);
}

// Figure 17.
void image_sizes(Bench& bench) {
  Chart chart{"image-size", "Figure 17: efficiency by image size", "pixels an edge", "throughput"};
  chart.log_x = true;
  Table table{"image-sizes", {"image"}};
  for (const SceneName scene : kScenes) {
    chart.series.push_back(name_of(scene));
    table.columns.insert(table.columns.end(), {name_of(scene) + ": throughput", "hit ratio"});
  }
  const int design = bench.design().image;
  for (const int image : {design / 8, design / 4, design / 2, design, 2 * design}) {
    std::vector<std::string> row{fmt::format("{0}^2", image)};
    chart.points.push_back({double(image), {}});
    for (const SceneName scene : kScenes) {
      const Measurement& m = bench.get(at_image(bench.run(scene), image));
      chart.points.back().second.push_back(throughput(m));
      row.insert(row.end(), {percent(throughput(m)), percent(hit_ratio(m), 1)});
    }
    table.rows.push_back(row);
  }
  bench.page().chart(chart, "Oblique views.");
  bench.page().table(table);
}

Run one_block(const Bench& bench, SceneName scene, double step) {
  Run run = bench.run(scene).at_step(step);
  run.kind = Run::Kind::kFillBlock;
  run.faint = true;
  run.leap = false;
  run.picture = false;
  return run;
}

void one_block(Bench& bench) {
  const int n = bench.design().block();
  const auto words = static_cast<std::uint64_t>((n + 1) * (n + 1) * (n + 1));
  Table table{"one-block", {"scene", "step, voxels", "samples", "voxels fetched", "(n+1)^3", "samples without a miss"}};
  bool exact = true, second_hits = true;
  std::uint64_t fetched = 0;
  for (const SceneName scene : {SceneName::kBuckyball, SceneName::kCloud, SceneName::kRock}) {
    std::uint64_t hits_at_one = 0;
    for (const double step : {1.0, 0.5, 0.25}) {
      const Measurement& m = bench.get(one_block(bench, scene, step));
      fetched = m.counters.value("processor.cache.filled_voxels");
      const std::uint64_t samples = m.counters.value("processor.samples"),
                          hits = m.counters.value("processor.cache.samples_with_misses.0");
      if (step == 1) hits_at_one = hits;
      // All samples but the first of each cell hit, whatever the first did.
      second_hits = second_hits && samples - hits <= static_cast<std::uint64_t>(n * n * n) - hits_at_one;
      exact = exact && fetched == words;
      table.rows.push_back({name_of(scene), fmt::format("{:g}", step), std::to_string(samples), std::to_string(fetched),
                            std::to_string(words), percent(ratio(double(hits), double(samples)), 1)});
    }
  }
  bench.page().text(
      fmt::format("Rays made by the host through one block along z, one in each column of its cells: {}^2 rays, ended "
                  "by a cut plane at the block's far face.",
                  n));
  bench.page().table(table);
  const auto shares = [&](double step) {
    std::vector<double> hit;
    for (const SceneName scene : kScenes) hit.push_back(miss_histogram(bench.get(bench.run(scene).at_step(step)))[0]);
    return spread_of(hit).mean;
  };
  std::vector<double> small, big;
  for (const SceneName scene : kScenes) {
    small.push_back(throughput(bench.get(at_image(bench.run(scene), bench.design().image / 8))));
    big.push_back(throughput(bench.get(at_image(bench.run(scene), 2 * bench.design().image))));
  }
  const double few = spread_of(small).mean, many = spread_of(big).mean;
  bench.page().claim(
      {17, "misses a sample by sampling distance (Figure 9); efficiency by image size (Figure 17)",
       "second sample in a cell hits 100%; grows with the image",
       fmt::format("second sample in a cell of a whole block hits: {}; samples without a miss {}, {}, {} at steps of "
                   "1, 0.5, 0.25; throughput {} at {}^2 to {} at {}^2",
                   second_hits ? "100%" : "not always", percent(shares(1)), percent(shares(0.5)), percent(shares(0.25)),
                   percent(few), bench.design().image / 8, percent(many), 2 * bench.design().image),
       !second_hits || many < few,
       "a cell that was fetched was lost again before its second sample, or larger images were slower: see the "
       "tables"});
  bench.page().claim({19, "compulsory misses of a block at one sample a voxel (2.1)",
                      fmt::format("(n+1)^3 = {}, never more than the block", words),
                      exact ? std::to_string(words) : std::to_string(fetched), !exact,
                      "the block was fetched in part twice, or not wholly: see the table"});
}

}  // namespace

void sampling_section(Bench& bench) {
  bench.page().heading("Sampling distance and image size");
  histogram(bench, SceneName::kBuckyball);
  histogram(bench, SceneName::kCloud);
  steps(bench);
  image_sizes(bench);
  one_block(bench);
}

}  // namespace gicube::samples::results
