#include "asic/raybus/ray_run.h"

#include <cassert>

namespace gicube::emu {

RunPool::Run RunPool::add(std::span<const RayToken> rays) {
  assert(!rays.empty());
  if (free_.empty()) {
    free_.push_back(static_cast<Run>(runs_.size()));
    runs_.emplace_back();
  }
  const Run run = free_.back();
  free_.pop_back();
  runs_[run].rays.assign(rays.begin(), rays.end());
  runs_[run].holders = listeners_;
  return run;
}

void RunPool::release(Run run) {
  assert(runs_[run].holders > 0);
  if (--runs_[run].holders == 0) free_.push_back(run);
}

}  // namespace gicube::emu
