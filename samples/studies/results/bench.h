// What every section of the page works with.
#pragma once

#include <filesystem>
#include <vector>

#include "studies/results/page.h"
#include "studies/results/runs.h"

namespace gicube::samples::results {

// The design point, scaled to another edge for tests.
struct Design {
  int edge = 256;   // voxels, N
  int image = 256;  // pixels

  int block() const;  // voxels, n: an 8 x 8 x 8 grid
  Settings settings() const;
};

class Bench {
 public:
  Bench(const Design& design, Runs& runs, Page& page) : design_(design), runs_(runs), page_(page) {}

  const Design& design() const { return design_; }
  Page& page() { return page_; }

  // A frame of the whole volume at the design point.
  Run run(SceneName scene, ViewName view = ViewName::kOblique) const;
  const Measurement& get(const Run& run) { return runs_.get(run); }
  const Measurement& frame(SceneName scene, ViewName view = ViewName::kOblique) { return get(run(scene, view)); }

  // A picture of a scene of global illumination with its own camera, lit by a pass of k rays a face voxel; and that pass.
  Run lit(SceneName scene, int k = 1, bool high_albedo = false) const;
  Run light(SceneName scene, int k = 1, bool high_albedo = false) const;
  std::vector<Run> lit_scenes() const;
  std::vector<Run> lights(bool high_albedo = false) const;

  // The figure's values over these runs, and what they have in common.
  template <typename Figure>
  std::vector<double> over(const std::vector<Run>& runs, const Figure& figure) {
    std::vector<double> values;
    for (const Run& each : runs) values.push_back(figure(get(each)));
    return values;
  }

  template <typename Figure>
  Spread spread(const std::vector<Run>& runs, const Figure& figure) {
    return spread_of(over(runs, figure));
  }
  template <typename Figure>
  double mean(const std::vector<Run>& runs, const Figure& figure) {
    return spread(runs, figure).mean;
  }

  // All scenes in all views; all scenes in the oblique view.
  std::vector<Run> all() const;
  std::vector<Run> oblique() const;

 private:
  Design design_;
  Runs& runs_;
  Page& page_;
};

// The machine of [P §5.1] that reordering is measured against: one queue a processor, rays in the order in which they come.
Run scanline(const Run& run, int queue);

// A table of the runs' pipeline cycles by their cause, a column each; its rows.
void add_causes(Bench& bench, const std::vector<Run>& runs, Table& table);

// The most frequent causes of cycles without a sample, over all of them: "cache_fill 12%, dsp 8%, latency 5%".
std::string lost_cycles(Bench& bench, const std::vector<Run>& runs);

// A DSP 8 times as fast that sends runs of 64 rays, and links that take a ray a cycle: what feeds the processors is no limit.
Settings fast_front_end();

// The sections, each a part of the page with its claims.
void scenes_section(Bench& bench);        // rows 5, 6, 23
void bounds_section(Bench& bench);        // where the time goes
void baseline_section(Bench& bench);      // row 1
void illumination_section(Bench& bench);  // rows 2 to 6
void light_sweep_section(Bench& bench);   // rows 4 and 6
void lit_baseline_section(Bench& bench);  // row 1
void block_loads_section(Bench& bench);   // row 18
void partition_section(Bench& bench);     // rows 7 to 10
void gains_section(Bench& bench);         // rows 11, 20
void speed_up_section(Bench& bench);      // row 12
void scaling_section(Bench& bench);       // rows 13 and 14
void cache_section(Bench& bench);         // rows 15 and 16
void sampling_section(Bench& bench);      // rows 17, 19
void bus_section(Bench& bench);           // row 21
void cost_section(Bench& bench);          // row 22
void parameters_section(Bench& bench);    // free parameters

}  // namespace gicube::samples::results
