#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr int kQueues[] = {16, 32, 64, 128, 256, 512, 1024, 4096};  // rays

// The queue at which the baseline takes the least time.
int best_queue(Bench& bench, const Run& run) {
  int best = kQueues[0];
  for (const int queue : kQueues) {
    if (asic_ms(bench.get(scanline(run, queue))) < asic_ms(bench.get(scanline(run, best)))) best = queue;
  }
  return best;
}

void queue_chart(Bench& bench) {
  Chart chart{"baseline-queue", "Scanline order, one queue", "rays of the queue", "ASIC ms"};
  chart.log_x = chart.log_y = true;
  for (const Run& run : bench.oblique()) chart.series.push_back(name_of(run.scene));
  for (const int queue : kQueues) {
    chart.points.emplace_back(queue, std::vector<double>{});
    for (const Run& run : bench.oblique()) {
      chart.points.back().second.push_back(asic_ms(bench.get(scanline(run, queue))));
    }
  }
  bench.page().chart(chart, "The baseline's best queue is the lowest point.");
}

}  // namespace

void baseline_section(Bench& bench) {
  Page& page = bench.page();
  page.heading("Reordering against scanline order");
  page.text(
      "The machine of section 5.1 that reordering is measured against, for rendering: one queue a processor, rays in "
      "the order in which they come, a direct-mapped cache of the same size with a tag a word, addressed by the "
      "voxel's place in the whole volume; at its best queue of those below. Oblique views.");
  queue_chart(bench);
  Table table{"baseline",
              {"scene", "best queue", "throughput, reordered", "scanline", "memory GB/s, reordered", "scanline",
               "Hz, reordered", "scanline", "rate gained"}};
  std::vector<double> gains, ours_busy, theirs_busy, ours_memory, theirs_memory, ours_rate, theirs_rate;
  for (const Run& run : bench.oblique()) {
    const int queue = best_queue(bench, run);
    const Measurement &ours = bench.get(run), &theirs = bench.get(scanline(run, queue));
    gains.push_back(ratio(rate_hz(ours), rate_hz(theirs)));
    ours_busy.push_back(throughput(ours)), theirs_busy.push_back(throughput(theirs));
    ours_memory.push_back(memory_gb_s(ours)), theirs_memory.push_back(memory_gb_s(theirs));
    ours_rate.push_back(rate_hz(ours)), theirs_rate.push_back(rate_hz(theirs));
    table.rows.push_back({name_of(run.scene), std::to_string(queue), percent(throughput(ours)),
                          percent(throughput(theirs)), number(memory_gb_s(ours), 2), number(memory_gb_s(theirs), 2),
                          number(rate_hz(ours)), number(rate_hz(theirs)), fmt::format("x {:.2f}", gains.back())});
  }
  page.table(table);
  std::vector<Run> best;
  for (const Run& run : bench.oblique()) best.push_back(scanline(run, best_queue(bench, run)));
  const auto mean = [](const std::vector<double>& values) { return spread_of(values).mean; };
  const double gain = mean(gains);
  page.claim({1, "reordering against scanline order (5.1), rendering alone",
              "global illumination: 93%, 0.8 GB/s, 16.3 Hz against 52%, 1.9 GB/s, 9.2 Hz: x 1.77",
              fmt::format("{}, {:.1f} GB/s, {:.1f} Hz against {}, {:.1f} GB/s, {:.1f} Hz: x {:.2f}",
                          percent(mean(ours_busy)), mean(ours_memory), mean(ours_rate), percent(mean(theirs_busy)),
                          mean(theirs_memory), mean(theirs_rate), gain),
              differs(gain, 1.77, 1.77),
              fmt::format("the paper compares the two in global illumination (next row), whose scattered rays come in "
                          "no order. Primary rays alone gain {:.2f} times: what the baseline loses is {}",
                          gain, lost_cycles(bench, best))});
}

}  // namespace gicube::samples::results
