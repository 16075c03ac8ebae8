// Carries out runs on one emulated board.
#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "studies/results/runs.h"

namespace gicube::samples::results {

// Each scene is made once and shared; it is made by who asks first, while others wait for it.
class SceneStore {
 public:
  std::shared_ptr<const SceneData> get(const Run& run);

 private:
  using Future = std::shared_future<std::shared_ptr<const SceneData>>;
  std::mutex mutex_;
  std::map<std::string, Future> scenes_;
};

// The runs must share a board_key(). Each result goes to `keep` at once. Throws std::runtime_error: a run's key and what
// the driver said.
void carry_out(const std::vector<Run>& runs, SceneStore& scenes,
               const std::function<void(const Run&, Measurement)>& keep);

}  // namespace gicube::samples::results
