#include "host_traps.h"

#include <algorithm>
#include <string>

namespace gicube::emu {

void HostTraps::begin(bool light, wire::EnergyRules rules) {
  added_.clear();
  waiting_.clear();
  out_ = 0;
  light_ = light;
  rules_ = rules;
}

void HostTraps::add(const wire::TrappedRay& ray) {
  const std::lock_guard lock(mutex_);
  if (added_.size() + waiting_.size() == kMax) {
    throw RoutineFault("more than " + std::to_string(kMax) +
                       " rays wait for the host: a smaller image or fewer lighting rays a command would help");
  }
  added_.push_back(ray);
}

void HostTraps::settle() {
  // No two rays of a command have the same (v, u).
  std::sort(added_.begin(), added_.end(),
            [](const auto& a, const auto& b) { return a.ray.host_id() < b.ray.host_id(); });
  waiting_.insert(waiting_.end(), added_.begin(), added_.end());
  added_ = {};
}

std::vector<wire::TrappedRay> HostTraps::take(std::size_t most) {
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(most, waiting_.size()));
  std::vector<wire::TrappedRay> first(waiting_.begin(), end);
  waiting_.erase(waiting_.begin(), end);
  out_ += first.size();
  return first;
}

}  // namespace gicube::emu
