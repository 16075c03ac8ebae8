#include "studies/results/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace gicube::samples::results {

int Design::block() const { return std::max(8, edge / 8); }

Settings Design::settings() const {
  Settings settings;
  if (block() != 32) settings["asic.block_voxels"] = std::to_string(block());
  if (edge != 256) settings["asic.max_volume_voxels"] = std::to_string(edge);
  return settings;
}

Run Bench::run(SceneName scene, ViewName view) const {
  Run run;
  run.scene = scene;
  run.view = view;
  run.dims = {design_.edge, design_.edge, design_.edge};
  run.edge = design_.edge;
  run.width = run.height = design_.image;
  run.picture = view == ViewName::kOblique;
  run.settings = design_.settings();
  return run;
}

Run Bench::lit(SceneName scene, int k, bool high_albedo) const {
  Run lit = run(scene);
  lit.light_rays = k;
  lit.high_albedo = high_albedo;
  lit.picture = k == 1 && !high_albedo;
  return lit;
}

Run Bench::light(SceneName scene, int k, bool high_albedo) const {
  Run light = lit(scene, k, high_albedo);
  light.kind = Run::Kind::kLight;
  light.picture = false;
  return light;
}

std::vector<Run> Bench::lit_scenes() const {
  std::vector<Run> runs;
  for (const SceneName scene : kLitScenes) runs.push_back(lit(scene));
  return runs;
}

std::vector<Run> Bench::lights(bool high_albedo) const {
  std::vector<Run> runs;
  for (const SceneName scene : kLitScenes) runs.push_back(light(scene, 1, high_albedo));
  return runs;
}

std::vector<Run> Bench::all() const {
  std::vector<Run> runs;
  for (const SceneName scene : kScenes) {
    for (const ViewName view : kViews) runs.push_back(run(scene, view));
  }
  return runs;
}

std::vector<Run> Bench::oblique() const {
  std::vector<Run> runs;
  for (const SceneName scene : kScenes) runs.push_back(run(scene));
  return runs;
}

std::string lost_cycles(Bench& bench, const std::vector<Run>& runs) {
  std::map<std::string, double> shares;
  for (const Run& run : runs) {
    for (const auto& [name, share] : cause_shares(bench.get(run))) {
      if (name != "busy") shares[name] += share / static_cast<double>(runs.size());
    }
  }
  std::vector<std::pair<std::string, double>> sorted(shares.begin(), shares.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, sorted.size()); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", sorted[i].first, percent(sorted[i].second));
  }
  return text;
}

Run scanline(const Run& run, int queue) { return run.with("sorter.queues", "single").with("asic.queue_rays", queue); }

void add_causes(Bench& bench, const std::vector<Run>& runs, Table& table) {
  for (const auto& [name, share] : cause_shares(bench.get(runs.front()))) table.rows.push_back({name});
  for (const Run& run : runs) {
    const auto shares = cause_shares(bench.get(run));
    for (std::size_t i = 0; i < shares.size(); ++i) table.rows[i].push_back(percent(shares[i].second, 1));
  }
}

}  // namespace gicube::samples::results
