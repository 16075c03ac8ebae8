// Carries out runs on one emulated board.
#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "studies/results/scenes.h"

namespace gicube::samples::results {

using Json = nlohmann::ordered_json;

// bench.py says what the fields mean.
struct Run {
  std::string name;  // in messages
  std::string kind, scene, view;
  Dims dims{};
  int edge = 0, width = 0, height = 0;
  double step = 0;
  bool leap = false, jitter = false, faint = false, orthographic = false;
  int light_rays = 0;
  bool high_albedo = false;
  std::string picture;  // file that gets the image; empty: none
  std::map<std::string, std::string> settings;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Run, name, kind, scene, view, dims, edge, width, height, step, leap, jitter, faint,
                                   orthographic, light_rays, high_albedo, picture, settings)

// Each scene is made once and shared; it is made by who asks first, while others wait for it.
class SceneStore {
 public:
  std::shared_ptr<const SceneData> get(const Run& run);

 private:
  using Future = std::shared_future<std::shared_ptr<const SceneData>>;
  std::mutex mutex_;
  std::map<std::tuple<std::string, Dims, int>, Future> scenes_;
};

// The runs must share scene, settings and light. Each result, the arguments of figures.py's Measurement, goes to `keep` at once with
// the run's place. Throws std::runtime_error: a run's name and what the driver said.
void measure(const std::vector<Run>& runs, SceneStore& scenes, const std::function<void(std::size_t, Json)>& keep);

}  // namespace gicube::samples::results
