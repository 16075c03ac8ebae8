#include <fmt/format.h>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

// Passes in low albedo with samples a voxel apart.
std::vector<Run> at_voxel_steps(const Bench& bench) {
  std::vector<Run> runs;
  for (const Run& run : bench.lights()) runs.push_back(run.at_step(1));
  return runs;
}

double millions(const Measurement& m, const char* name) { return 1e-6 * static_cast<double>(m.counters.value(name)); }

void passes(Bench& bench) {
  Table table{"illumination",
              {"scene", "albedo", "M rays", "pass ms", "M samples", "M samples/s", "throughput",
               "deposits /100 samples", "tiles a deposit", "of them combined", "memory GB/s", "memory in use",
               "in use without combining", "hit ratio", "DSP busy", "overflows a ray", "energy clipped"}};
  for (const bool high : {false, true}) {
    for (const Run& run : bench.lights(high)) {
      const Measurement& m = bench.get(run);
      table.rows.push_back(
          {name_of(run.scene), high ? "high" : "low", number(millions(m, "dsp.lighting_rays"), 3), number(frame_ms(m)),
           number(millions(m, "processor.samples"), 1), number(samples_per_second(m) * 1e-6, 0), percent(throughput(m)),
           number(100 * deposits_a_sample(m), 1), number(tiles_a_deposit(m), 2), percent(tiles_combined(m)),
           number(memory_gb_s(m), 2), percent(memory_use(m)), percent(memory_use_uncombined(m)),
           percent(hit_ratio(m), 1), percent(dsp_use(m)), number(overflows_a_ray(m), 2), percent(m.clipped, 1)});
    }
  }
  bench.page().table(table);
}

void frames(Bench& bench) {
  Table table{"lit-frames",
              {"scene", "frame ms", "Hz", "ASIC ms", "M samples", "M samples/s", "throughput", "scatterings /100 rays",
               "memory GB/s", "memory in use", "hit ratio", "DSP busy"}};
  for (const Run& run : bench.lit_scenes()) {
    const Measurement& m = bench.get(run);
    table.rows.push_back({name_of(run.scene), number(frame_ms(m)), number(rate_hz(m)), number(asic_ms(m)),
                          number(millions(m, "processor.samples"), 1), number(samples_per_second(m) * 1e-6, 0),
                          percent(throughput(m)), number(100 * scatterings_a_ray(m), 1), number(memory_gb_s(m), 2),
                          percent(memory_use(m)), percent(hit_ratio(m), 1), percent(dsp_use(m))});
  }
  bench.page().table(table);
}

void causes(Bench& bench) {
  Table table{"lit-causes", {"cause"}};
  std::vector<Run> runs;
  for (const bool high : {false, true}) {
    for (const Run& run : bench.lights(high)) {
      table.columns.push_back(name_of(run.scene) + (high ? ", high" : ", low"));
      runs.push_back(run);
    }
  }
  add_causes(bench, runs, table);
  bench.page().text("Pipeline cycles of the passes by their cause; columns sum to 100%.");
  bench.page().table(table);
}

void sample_claims(Bench& bench) {
  const Spread low = bench.spread(bench.lights(), samples_per_second),
               high = bench.spread(bench.lights(true), samples_per_second),
               seen = bench.spread(bench.lit_scenes(), samples_per_second);
  bench.page().claim(
      {2, "samples a second, lighting, p=4 (5.1)", "122 M",
       fmt::format("low albedo mean {} M, high {} M", low.text(1e6, 0), high.text(1e6, 0)),
       differs(low.mean, 122e6, 122e6) || differs(high.mean, 122e6, 122e6),
       fmt::format(
           "only a part of our samples deposits (next rows), so that a splat seldom stops a pipeline: of the cycles "
           "without a sample in low albedo most go to {}. With voxel steps, which miss more, it is mean {} M",
           lost_cycles(bench, bench.lights()), bench.spread(at_voxel_steps(bench), samples_per_second).text(1e6, 0))});
  bench.page().claim({2, "samples a second, rendering with scattered rays, p=4 (5.1)", "231 M",
                      fmt::format("mean {} M", seen.text(1e6, 0)), differs(seen.mean, 231e6, 231e6),
                      fmt::format("cycles without a sample: {}", lost_cycles(bench, bench.lit_scenes()))});
}

void memory_claims(Bench& bench) {
  const std::vector<Run> low = bench.lights(), wide = at_voxel_steps(bench);
  const auto mean = [&](const std::vector<Run>& runs, double (*figure)(const Measurement&)) {
    return bench.spread(runs, figure);
  };
  constexpr double kMax = 6.4, kPaper = 4.6;  // GB/s: of four RDRAMs; in global illumination
  const Run fog = bench.light(SceneName::kFogBox);
  const Measurement &fine = bench.get(fog.with("asic.datapath", "wide")), &coarse = bench.get(fog.at_step(1));
  const std::string why = fmt::format(
      "the splats. Of 100 samples only {:.1f} deposit, for most of a ray's way is empty and its energy of 8 bits has "
      "255 units to give; a deposit is most often one unit, which goes to one voxel, and changes {:.1f} tiles in the "
      "mean. So most of the traffic is reads, as in rendering. That {} of the changed tiles are written with an "
      "earlier change decides little: with a read and a write for each the interface would be in use {}. Where each "
      "sample deposits into all eight voxels, in the fog box with energies of 24 bits, it is in use {}, stands {} of "
      "the time to turn from writes to reads and back, and the samples fall to {:.0f} M/s. The sampling distance "
      "decides more: with voxel steps the fog box moves {:.1f} GB/s and uses {}. The paper's two rows don't agree: "
      "{:.1f} of the {:.1f} GB/s that four RDRAMs give are {}, not 92%",
      100 * mean(low, deposits_a_sample).mean, mean(low, tiles_a_deposit).mean, percent(mean(low, tiles_combined).mean),
      percent(mean(low, memory_use_uncombined).mean), percent(memory_use(fine)), percent(memory_turnaround(fine)),
      samples_per_second(fine) * 1e-6, memory_gb_s(coarse), percent(memory_use(coarse)), kPaper, kMax,
      percent(kPaper / kMax));
  const Spread memory = mean(low, memory_gb_s), use = mean(low, memory_use);
  bench.page().claim(
      {5, "memory bandwidth, lighting pass (3.3)", "4.6 GB/s",
       fmt::format("mean {} GB/s; {} with voxel steps", memory.text(1, 1), mean(wide, memory_gb_s).text(1, 1)),
       differs(memory.mean, 4.6, 4.6), why});
  bench.page().claim(
      {6, "memory interface in use, lighting pass (3.6)", "92%",
       fmt::format("mean {}%; {}% with voxel steps", use.text(0.01, 0), mean(wide, memory_use).text(0.01, 0)),
       differs(use.mean, 0.92, 0.92), "as row 5"});
}

// Volume rendering with reflections: no illumination pass, the reflectance map lights it.
void mirrors_claim(Bench& bench) {
  constexpr double kPaper = 22.7;  // ms
  Run run = bench.lit(SceneName::kMirrorHead);
  run.light_rays = 0;
  run.picture = false;
  run.width = run.height = bench.design().image * 300 / 256;
  const Measurement &m = bench.get(run), &wide = bench.get(run.at_step(1));
  Run fast = run.at_step(1).with(fast_front_end());
  bench.page().claim(
      {3, fmt::format("head with mirrors, {}^2 (4.1)", run.width), "22.7 ms (a scanned brain)",
       fmt::format("{:.1f} ms, of them {:.1f} on the ASIC; {:.1f} with voxel steps", frame_ms(m), asic_ms(m),
                   frame_ms(wide)),
       differs(frame_ms(m), kPaper, kPaper),
       fmt::format(
           "the scene, and the sampling distance. Ours takes {:.1f} M samples, {:.0f} scatterings in 100 rays; {:.1f} "
           "ms of it are tables and image on the bus. With voxel steps it takes {:.1f} M samples and {:.1f} ms, and "
           "{:.1f} ms if a DSP eight times as fast sends runs of rays and links are wide. Cycles without a sample: {}",
           millions(m, "processor.samples"), 100 * scatterings_a_ray(m), frame_ms(m) - asic_ms(m),
           millions(wide, "processor.samples"), frame_ms(wide), frame_ms(bench.get(fast)), lost_cycles(bench, {run}))});
}

}  // namespace

void illumination_section(Bench& bench) {
  Page& page = bench.page();
  page.heading("Global illumination");
  Table about{"lit-scenes", {"scene", "what it is there for"}};
  for (const Run& run : bench.lit_scenes()) {
    about.rows.push_back({name_of(run.scene), results::about(run.scene)});
    page.picture("scene-" + name_of(run.scene) + ".png", name_of(run.scene));
  }
  page.table(about);
  page.text(fmt::format(
      "The scenes of samples/scenes with {} voxels along their longest edge, one ray a pixel, and one lighting ray a "
      "voxel of the volume's faces (k = 1) in one pass for all colours; conserving rules. *In use without combining*: "
      "if each changed tile were fetched and written on its own, as the paper's read-modify-write.",
      bench.design().edge));
  passes(bench);
  causes(bench);
  page.text("Frames that the passes in low albedo light, with rays scattered by mirrors and metal; half-voxel steps.");
  frames(bench);
  sample_claims(bench);
  mirrors_claim(bench);
  memory_claims(bench);
}

}  // namespace gicube::samples::results
