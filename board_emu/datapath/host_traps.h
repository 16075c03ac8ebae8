// Rays that wait on the DSP for the host's scattering routine, until the host has fetched them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "datapath/scattering.h"
#include "gicube/archive.h"
#include "gicube/wire/command.h"
#include "gicube/wire/trap.h"
#include "words/record_list.h"

namespace gicube::emu {

class HostTraps {
 public:
  static constexpr std::size_t kMax = std::size_t{1} << 22;  // chosen: 128 MB of packets in the DSP's SDRAM

  // Discards all rays. `light`: whether the next command has lighting rays. `rules`: for lighting rays.
  void begin(bool light, wire::EnergyRules rules) {
    added_.clear();
    waiting_.clear();
    out_ = 0;
    light_ = light;
    rules_ = rules;
  }
  bool is_light() const { return light_; }
  wire::EnergyRules rules() const { return rules_; }

  // Thread-safe. Throws RoutineFault if there are too many.
  void add(const wire::TrappedRay& ray) {
    const std::lock_guard lock(mutex_);
    if (added_.size() + waiting_.size() == kMax) {
      throw RoutineFault("more than " + std::to_string(kMax) +
                         " rays wait for the host: a smaller image or fewer lighting rays per command would help");
    }
    added_.push_back(ray);
  }

  // Only add() may be called during a command or step. settle() sorts the added rays, so that their order does not
  // depend on threads and time: no two rays of a command have the same (v, u).
  void settle() {
    std::ranges::sort(added_, {}, [](const wire::TrappedRay& trapped) { return trapped.ray.host_id(); });
    waiting_.insert(waiting_.end(), added_.begin(), added_.end());
    added_ = {};
  }
  std::size_t waiting() const { return waiting_.size(); }
  // Removes the first waiting rays and counts them as sent to the host.
  std::vector<wire::TrappedRay> take(std::size_t max_rays) {
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(max_rays, waiting_.size()));
    std::vector<wire::TrappedRay> first(waiting_.begin(), end);
    waiting_.erase(waiting_.begin(), end);
    out_ += first.size();
    return first;
  }
  // Rays that were sent to the host and are not answered yet.
  std::uint64_t out() const { return out_; }
  void answered(std::uint64_t rays) { out_ -= rays; }
  void state(Archive& archive) {
    records_state(archive, "added", added_, kMax * wire::kTrappedRayBytes);
    records_state(archive, "waiting", waiting_, kMax * wire::kTrappedRayBytes);
    archive("out", out_);
    archive("light", light_);
    archive.at_most("rules", rules_, wire::EnergyRules::kConserving);
  }

 private:
  std::mutex mutex_;  // for added_
  std::vector<wire::TrappedRay> added_;
  std::deque<wire::TrappedRay> waiting_;
  std::uint64_t out_ = 0;
  bool light_ = false;
  wire::EnergyRules rules_ = wire::EnergyRules::kConserving;
};

}  // namespace gicube::emu
