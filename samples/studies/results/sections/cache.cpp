#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr int kQueues[] = {1, 4, 8, 16, 32, 64, 256, 1024};  // rays
constexpr int kDesignQueue = 256, kPipelineLatency = 32;     // rays, cycles

struct Grid {
  std::string name;
  Run run;
  std::vector<int> blocks;  // voxels
};

std::vector<int> blocks_of(const Bench& bench) {
  std::vector<int> blocks;
  for (const int n : {8, 16, 32, 64}) {
    if (n <= bench.design().edge) blocks.push_back(n);
  }
  return blocks;
}

Run at(const Run& run, int block, int queue) {
  const Run sized = run.with("asic.block_voxels", block);
  return queue == kDesignQueue ? sized : sized.with("asic.queue_rays", queue);
}

// One volume of as many voxels as the largest block has, and one processor: n = N.
Grid small_grid(Bench& bench) {
  const std::vector<int> blocks = blocks_of(bench);
  Run run = bench.run(SceneName::kHead).with("asic.processors", 1);
  run.dims = {blocks.back(), blocks.back(), blocks.back()};
  run.edge = blocks.back();
  run.width = run.height = blocks.back();
  return {"small", run, blocks};
}

template <typename Figure>
void chart(Bench& bench, const Grid& grid, const std::string& name, const std::string& title, const std::string& label,
           bool log_y, const Figure& figure) {
  Chart chart{name + "-" + grid.name, title, "rays of a queue", label};
  chart.log_x = true;
  chart.log_y = log_y;
  for (const int n : grid.blocks) chart.series.push_back(fmt::format("n = {}", n));
  for (const int queue : kQueues) {
    chart.points.emplace_back(queue, std::vector<double>{});
    for (const int n : grid.blocks) chart.points.back().second.push_back(figure(bench.get(at(grid.run, n, queue))));
  }
  bench.page().chart(chart, title + ".");
}

void grid_table(Bench& bench, const Grid& grid) {
  Table table{"grid-" + grid.name, {"rays of a queue"}};
  for (const int n : grid.blocks) table.columns.insert(table.columns.end(), {fmt::format("n = {}: hits", n), "ms"});
  for (const int queue : kQueues) {
    std::vector<std::string> row{std::to_string(queue)};
    for (const int n : grid.blocks) {
      const Measurement& m = bench.get(at(grid.run, n, queue));
      row.insert(row.end(), {percent(hit_ratio(m), 1), number(asic_ms(m), 2)});
    }
    table.rows.push_back(row);
  }
  bench.page().table(table);
}

void associativity(Bench& bench) {
  Table table{"associativity", {"rays of a queue"}};
  const Run run = bench.run(SceneName::kBuckyball);
  for (const int ways : {1, 2, 4})
    table.columns.insert(table.columns.end(), {fmt::format("{} way{}: hits", ways, ways == 1 ? "" : "s"), "ms"});
  for (const int queue : kQueues) {
    std::vector<std::string> row{std::to_string(queue)};
    for (const int ways : {1, 2, 4}) {
      const Run with_queue = queue == kDesignQueue ? run : run.with("asic.queue_rays", queue);
      const Measurement& m =
          bench.get(ways == 1 ? at(run, bench.design().block(), queue) : with_queue.with("cache.ways", ways));
      row.insert(row.end(), {percent(hit_ratio(m), 1), number(asic_ms(m), 2)});
    }
    table.rows.push_back(row);
  }
  bench.page().text("The paper names associativity as a cure for short queues; buckyball, design block:");
  bench.page().table(table);
}

double hits(Bench& bench, const Grid& grid, int block, int queue) {
  return hit_ratio(bench.get(at(grid.run, block, queue)));
}
double time(Bench& bench, const Grid& grid, int block, int queue) {
  return asic_ms(bench.get(at(grid.run, block, queue)));
}

int fastest_block(Bench& bench, const Grid& grid) {
  return *std::min_element(grid.blocks.begin(), grid.blocks.end(), [&](int a, int b) {
    return time(bench, grid, a, kDesignQueue) < time(bench, grid, b, kDesignQueue);
  });
}

// Which block is best, with and without leaps: what reordering alone prefers.
std::string blocks_table(Bench& bench) {
  const std::vector<int> blocks = blocks_of(bench);
  Table table{"blocks", {"scene", "leaps"}};
  for (const int n : blocks) table.columns.push_back(fmt::format("n = {}, ms", n));
  table.columns.push_back("best n");
  std::string best;
  for (const SceneName scene : kScenes) {
    for (const bool leap : {true, false}) {
      std::vector<std::string> row{name_of(scene), leap ? "yes" : "no"};
      std::vector<double> times;
      for (const int n : blocks) {
        Run run = at(bench.run(scene), n, kDesignQueue);
        run.leap = leap;
        run.picture = false;
        times.push_back(asic_ms(bench.get(run)));
        row.push_back(number(times.back(), 2));
      }
      const auto least = static_cast<std::size_t>(std::min_element(times.begin(), times.end()) - times.begin());
      row.push_back(std::to_string(blocks[least]));
      table.rows.push_back(row);
      if (!leap) best += fmt::format("{}{} {}", best.empty() ? "" : ", ", name_of(scene), blocks[least]);
    }
  }
  bench.page().text("Time by block with queues of the design point, with and without leaps over empty blocks:");
  bench.page().table(table);
  return best;
}

void hit_claim(Bench& bench, const std::vector<Grid>& grids, const Grid& small) {
  bool grows_with_queue = true, grows_with_block = true;
  std::string jumps;
  for (const Grid& grid : grids) {
    const int n = bench.design().block();
    grows_with_queue = grows_with_queue && hits(bench, grid, n, kQueues[0]) < hits(bench, grid, n, 64) &&
                       hits(bench, grid, n, 64) < hits(bench, grid, n, 1024);
    for (std::size_t i = 1; i < grid.blocks.size(); ++i) {
      grows_with_block = grows_with_block && hits(bench, grid, grid.blocks[i - 1], kDesignQueue) <
                                                 hits(bench, grid, grid.blocks[i], kDesignQueue);
    }
    jumps += fmt::format("{}{}: {} at 16, {} at {}", jumps.empty() ? "" : "; ", grid.name,
                         percent(hits(bench, grid, n, 16), 1), percent(hits(bench, grid, n, 2 * kPipelineLatency), 1),
                         2 * kPipelineLatency);
  }
  const double whole = hits(bench, small, small.blocks.back(), kDesignQueue);
  bench.page().claim(
      {15, "hit ratio against block and queue size (5.1, Figure 13)",
       "grows with both; jumps past queues of 16; below 100% at n = N",
       fmt::format("grows with queues: {}; with blocks: {}; {}; {} at n = N", grows_with_queue ? "yes" : "no",
                   grows_with_block ? "yes" : "no", jumps, percent(whole, 1)),
       !(grows_with_queue && grows_with_block && whole < 1),
       "with queues shorter than the pipeline the few rays of a block come round so seldom that hits are those of "
       "neighbouring rays in the order of the image; see the tables"});
}

void time_claim(Bench& bench, const std::vector<Grid>& grids, const Grid& small, const std::string& without_leaps) {
  std::string best;
  bool same = true;
  const int edge = bench.design().edge;
  for (const Grid& grid : grids) {
    const int n = fastest_block(bench, grid);
    same = same && n == bench.design().block();
    best += fmt::format("{}{}: n = {} ({}^3 grid)", best.empty() ? "" : ", ", grid.name, n, edge / n);
  }
  const int whole = small.blocks.back();
  const double least = time(bench, small, whole, 64), most = time(bench, small, whole, 1024);
  bench.page().claim(
      {16, "time against block and queue size (5.1, Figure 14)", "queue size idle at n = N; an 8 x 8 x 8 grid is best",
       fmt::format("n = N: {:.2f} ms at queues of 64, {:.2f} ms at 1024; best of queues of 256: {}", least, most, best),
       !same || differs(least, most, most),
       fmt::format("larger blocks miss less, smaller ones cut a scene's empty space more finely, so rays leap more of "
                   "it: which wins is the scene's. Without leaps the best blocks are {}: reordering alone asks for "
                   "larger ones here, since queues of 256 rays are long against the pipeline",
                   without_leaps)});
}

}  // namespace

void cache_section(Bench& bench) {
  bench.page().heading("Blocks and queues");
  std::vector<Grid> grids;
  for (const SceneName scene : {SceneName::kBuckyball, SceneName::kHead}) {
    grids.push_back({name_of(scene), bench.run(scene), blocks_of(bench)});
  }
  const Grid small = small_grid(bench);
  bench.page().text(
      fmt::format("Hit ratio is that of voxels. The caches hold at most 64^3 blocks, so n = N is measured on a head of "
                  "{0}^3 voxels with one processor and a {0}^2 image.",
                  small.blocks.back()));
  for (const Grid& grid : grids) {
    chart(bench, grid, "hit-ratio", "Figure 13: hit ratio, " + grid.name, "hit ratio", false, hit_ratio);
    chart(bench, grid, "time", "Figure 14: time, " + grid.name, "ASIC ms", true, asic_ms);
    grid_table(bench, grid);
  }
  chart(bench, small, "hit-ratio", "Figure 13 with n = N: hit ratio", "hit ratio", false, hit_ratio);
  chart(bench, small, "time", "Figure 14 with n = N: time", "ASIC ms", true, asic_ms);
  grid_table(bench, small);
  associativity(bench);
  const std::string without_leaps = blocks_table(bench);
  hit_claim(bench, grids, small);
  time_claim(bench, grids, small, without_leaps);
}

}  // namespace gicube::samples::results
