#include <fmt/format.h>

#include <cmath>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr int kRays[] = {1, 2, 3};                                                            // a face voxel, k
constexpr double kPaperPass = 361, kPaperRate = 39, kPaperSamples = 122e6, kPaperUse = 0.92;  // ms, Hz
constexpr SceneName kBall = SceneName::kMirrorBuckyball;

int nearest(Bench& bench, bool high_albedo) {
  int best = kRays[0];
  const auto off = [&](int k) {
    return std::abs(frame_ms(bench.get(bench.light(kBall, k, high_albedo))) - kPaperPass);
  };
  for (const int k : kRays) best = off(k) < off(best) ? k : best;
  return best;
}

void rays_chart(Bench& bench) {
  Chart chart{"light-rays", "Mirrored buckyball: illumination pass", "rays a face voxel, k", "ms"};
  chart.series = {"low albedo", "high albedo", "paper"};
  Table table{"light-rays",
              {"k", "low: M rays", "ms", "M samples/s", "memory in use", "turns in short stays", "energy clipped",
               "high: ms", "M samples/s", "memory in use", "turns in short stays", "energy clipped"}};
  table.name = "light-rays-table";
  for (const int k : kRays) {
    const Measurement &low = bench.get(bench.light(kBall, k)), &high = bench.get(bench.light(kBall, k, true));
    chart.points.push_back({double(k), {frame_ms(low), frame_ms(high), kPaperPass}});
    std::vector<std::string> row{std::to_string(k),
                                 number(1e-6 * static_cast<double>(low.counters.value("dsp.lighting_rays")), 3)};
    for (const Measurement* m : {&low, &high}) {
      row.insert(row.end(), {number(frame_ms(*m)), number(samples_per_second(*m) * 1e-6, 0), percent(memory_use(*m)),
                             percent(issued_in_short_stays(*m, 32), 1), percent(m->clipped, 1)});
    }
    table.rows.push_back(row);
  }
  bench.page().chart(chart, "The number of lighting rays decides a pass's length.");
  bench.page().table(table);
}

void pass_claim(Bench& bench) {
  const int low = nearest(bench, false), high = nearest(bench, true);
  const Measurement &pass = bench.get(bench.light(kBall, low)), &other = bench.get(bench.light(kBall, high, true));
  const Run run = bench.lit(kBall);
  const Measurement &frame = bench.get(run), &wide = bench.get(run.at_step(1));
  bench.page().claim(
      {4, "buckyball on a mirror: illumination pass; later frames (4.1)", "361 ms; 39 Hz",
       fmt::format("{:.0f} ms with k = {} (high albedo: {:.0f} ms with k = {}); {:.1f} Hz, {:.1f} with voxel steps",
                   frame_ms(pass), low, frame_ms(other), high, rate_hz(frame), rate_hz(wide)),
       differs(frame_ms(pass), kPaperPass, kPaperPass) || differs(rate_hz(frame), kPaperRate, kPaperRate),
       fmt::format("k and the sampling distance, which the paper does not give, are the scene's length of work: a "
                   "frame takes {:.1f} M samples with half-voxel steps and {:.1f} M with voxel steps, a pass {:.0f} ms "
                   "a ray of each face voxel. Cycles of the frame without a sample: {}",
                   1e-6 * static_cast<double>(frame.counters.value("processor.samples")),
                   1e-6 * static_cast<double>(wide.counters.value("processor.samples")), frame_ms(pass) / low,
                   lost_cycles(bench, {run}))});
}

struct Variant {
  std::string name;
  Settings settings;
  double step = 0.5;
};

std::vector<Variant> variants() {
  std::vector<Variant> list{{"design point", {}}};
  for (const int tiles : {64, 1024}) {
    list.push_back({fmt::format("{} changed tiles wait", tiles), {{"cache.write_packets", std::to_string(tiles)}}});
  }
  for (const int cycles : {15, 120}) {
    list.push_back(
        {fmt::format("{} DSP cycles a lighting ray", cycles), {{"dsp.lighting_ray_cycles", std::to_string(cycles)}}});
  }
  for (const int stages : {4, 32}) {
    list.push_back({fmt::format("{} compute stages", stages), {{"pipeline.compute_stages", std::to_string(stages)}}});
  }
  list.push_back({"queues of 1024 rays", {{"asic.queue_rays", "1024"}}});
  list.push_back({"skewed blocks", {{"asic.partition", "skewed_block"}}});
  list.push_back({"skewed blocks, DSP 8 times as fast, wide links",
                  {{"asic.partition", "skewed_block"}, {"dsp.clock_khz", "1600000"}, {"link.bits", "256"}}});
  list.push_back({"wide datapath: energies of 24 bits", {{"asic.datapath", "wide"}}});
  list.push_back({"two processors share an RDRAM", {{"rdram.processors_per_rdram", "2"}}});
  list.push_back({"perfect memory", {{"ideal.memory", "1"}}});
  list.push_back({"voxel steps", {}, 1});
  list.push_back({"voxel steps, two processors share an RDRAM", {{"rdram.processors_per_rdram", "2"}}, 1});
  return list;
}

void parameters(Bench& bench) {
  const SceneName scenes[] = {kBall, SceneName::kFogBox};
  Table table{"light-parameters", {"variant"}};
  for (const SceneName scene : scenes) {
    for (const char* column : {"ms", "M samples/s", "memory GB/s", "memory in use", "combined", "short stays"})
      table.columns.push_back(fmt::format("{}: {}", name_of(scene), column));
  }
  std::string samples, use;
  for (const Variant& variant : variants()) {
    std::vector<std::string> row{variant.name};
    for (const SceneName scene : scenes) {
      Run run = bench.light(scene).with(variant.settings);
      const Measurement& m = bench.get(run.at_step(variant.step));
      row.insert(row.end(),
                 {number(asic_ms(m)), number(samples_per_second(m) * 1e-6, 0), number(memory_gb_s(m), 2),
                  percent(memory_use(m)), percent(tiles_combined(m)), percent(issued_in_short_stays(m, 32), 1)});
      const auto note = [&](std::string& list, bool far) {
        if (!far) list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", variant.name, name_of(scene));
      };
      note(samples, differs(samples_per_second(m), kPaperSamples, kPaperSamples));
      note(use, differs(memory_use(m), kPaperUse, kPaperUse));
    }
    table.rows.push_back(row);
  }
  bench.page().text("Free parameters of a pass in low albedo with k = 1, one at a time:");
  bench.page().table(table);
  bench.page().text(fmt::format(
      "Within a quarter of the paper's 122 M samples/s: {}. Within a quarter of its 92% of the memory interface: {}.",
      samples.empty() ? "none" : samples, use.empty() ? "none" : use));
}

}  // namespace

void light_sweep_section(Bench& bench) {
  bench.page().heading("What decides a lighting pass");
  bench.page().text(
      "A stay is the time that a queue is the active one; a turn is a sample or leap in it. Stays of fewer than 32 "
      "turns are short: the pipeline is longer than that, so that no ray of them comes round.");
  rays_chart(bench);
  pass_claim(bench);
  parameters(bench);
}

}  // namespace gicube::samples::results
