#include <fmt/format.h>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

std::vector<std::string> row_of(const Run& run, const Measurement& m) {
  return {name_of(run.scene),
          name_of(run.view),
          number(frame_ms(m)),
          number(rate_hz(m)),
          number(asic_ms(m)),
          number(static_cast<double>(m.counters.value("processor.samples")) * 1e-6, 2),
          number(samples_per_second(m) * 1e-6, 0),
          percent(throughput(m)),
          number(memory_gb_s(m), 2),
          percent(memory_use(m)),
          percent(hit_ratio(m), 1),
          number(rays_sent(m), 2),
          percent(balance_held(m)),
          percent(dsp_use(m)),
          number(overflows_a_ray(m), 2)};
}

std::string range(const Spread& spread, double unit, int digits) { return "mean " + spread.text(unit, digits); }

// Oblique views with samples a voxel apart, or with the paper's jitter [P §2.1] half to a whole voxel.
double at_voxel_steps(Bench& bench, bool jitter, double (*figure)(const Measurement&)) {
  std::vector<double> values;
  for (const Run& run : bench.oblique()) {
    Run other = run.at_step(1);
    other.jitter = jitter;
    values.push_back(figure(bench.get(other)));
  }
  return spread_of(values).mean;
}

void memory_claims(Bench& bench) {
  const std::vector<Run> all = bench.all();
  const Spread memory = bench.spread(all, memory_gb_s), use = bench.spread(all, memory_use);
  const Spread samples = bench.spread(all, samples_per_second);
  const auto gb_s = [&](bool jitter) { return at_voxel_steps(bench, jitter, memory_gb_s); };
  const auto busy = [&](bool jitter) { return percent(at_voxel_steps(bench, jitter, memory_use)); };
  bench.page().claim({2, "samples a second, rendering, p=4 (5.1)", "231 M", range(samples, 1e6, 0) + " M",
                      differs(samples.mean, 231e6, 231e6),
                      "scenes and views differ; see the table of the design point"});
  const std::string why = fmt::format(
      "the sampling distance, which the paper does not give. 2.8 GB/s at 231 M samples/s are {:.1f} bytes a sample, "
      "ours are {:.1f} with half-voxel steps, because every second sample lies in a cell that the first has fetched. "
      "The oblique views move {:.1f} GB/s so; with steps of a voxel {:.1f} GB/s, the interface in use {} of the time; "
      "with such steps jittered, as the paper does it, {:.1f} GB/s and {}",
      2.8e9 / 231e6, ratio(memory.mean * 1e9, samples.mean), bench.mean(bench.oblique(), memory_gb_s), gb_s(false),
      busy(false), gb_s(true), busy(true));
  bench.page().claim({5, "memory bandwidth, rendering (3.3)", "2.8 GB/s",
                      fmt::format("{} GB/s; {:.1f} with jittered voxel steps", range(memory, 1, 1), gb_s(true)),
                      differs(memory.mean, 2.8, 2.8), why});
  bench.page().claim({6, "memory interface in use, rendering (3.6)", "37.5%",
                      fmt::format("{}%; {} with jittered voxel steps", range(use, 0.01, 0), busy(true)),
                      differs(use.mean, 0.375, 0.375), why});
}

void rate_claim(Bench& bench) {
  constexpr double kRate = 30;  // Hz
  const Spread rate = bench.spread(bench.oblique(), rate_hz);
  std::string slow;
  for (const Run& run : bench.oblique()) {
    const Measurement& m = bench.get(run);
    if (rate_hz(m) >= kRate) continue;
    const double samples = static_cast<double>(m.counters.value("processor.samples"));
    slow += fmt::format(
        "{}{} takes {:.1f} M samples a frame: the pipelines need {:.1f} ms for them alone, and image and tables {:.1f} "
        "ms of the bus; with steps of a voxel it reaches {:.1f} Hz",
        slow.empty() ? "" : "; ", name_of(run.scene), samples * 1e-6, ratio(samples, m.processors * m.core_hz) * 1e3,
        frame_ms(m) - asic_ms(m), rate_hz(bench.get(run.at_step(1))));
  }
  bench.page().claim({23, "256^3 in real time (3)", "30 Hz", range(rate, 1, 1) + " Hz", rate.min < kRate, slow});
}

}  // namespace

void scenes_section(Bench& bench) {
  Page& page = bench.page();
  const std::vector<Run> all = bench.all();
  page.heading("Scenes at the design point");
  Table about{"scenes",
              {"scene", "what it is there for", "blocks without anything visible", "samples that show something"}};
  for (const Run& run : bench.oblique()) {
    const Measurement& m = bench.get(run);
    about.rows.push_back({name_of(run.scene), results::about(run.scene),
                          m.counters.value("pipeline.leaps") > 0 ? "yes" : "none",
                          percent(ratio(static_cast<double>(m.counters.value("pipeline.visible_samples")),
                                        static_cast<double>(m.counters.value("pipeline.samples"))))});
    page.picture("scene-" + name_of(run.scene) + ".png", name_of(run.scene));
  }
  page.table(about);
  page.text(
      "Views are perspective, from outside, so near that the whole volume just fills the image; *along x* looks along "
      "the axis along which the slabs of a partition lie one behind the other. Frame is what the host sees, with "
      "tables, image and completion over the bus; ASIC is the time in which rays are under way, to which all shares "
      "and bandwidths refer. Memory bandwidth counts a packet of 144 bit as 16 bytes, as the paper's 1.6 GB/s of an "
      "18-bit RDRAM do.");
  Table table{"design-point",
              {"scene", "view", "frame ms", "Hz", "ASIC ms", "M samples", "M samples/s", "throughput", "memory GB/s",
               "memory in use", "hit ratio", "rays sent /100 cycles", "balance", "DSP busy", "overflows a ray"}};
  for (const Run& run : all) table.rows.push_back(row_of(run, bench.get(run)));
  page.table(table);

  memory_claims(bench);
  rate_claim(bench);
}

}  // namespace gicube::samples::results
