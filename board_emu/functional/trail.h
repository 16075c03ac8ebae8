// What rays that do more than gather meet on their way: for those who work out how long they take.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datapath/ray_step.h"
#include "words/words.h"

namespace gicube::emu {

// Where a ray is and how it goes on.
struct RayWay {
  Point position{}, step{};
  Rest rest{}, step_rest{};  // of the wide datapath
  std::array<std::int16_t, 3> direction{};
  std::uint16_t u = 0, v = 0;
};

inline RayWay way_of(const RayState& ray) {
  return {ray.position, ray.step, ray.rest, ray.step_rest, ray.direction, ray.u, ray.v};
}

struct TrailEvent {
  std::int32_t steps = 0;  // from the event before, or the beginning, to the sample that brings it, which counts
  bool deposits = false;   // its sample writes words
  bool turns = false;      // the ray goes on by `way`
  bool trapped = false;    // at the DSP
  bool waits = false;      // there, for the host: this ray does not go on
  bool ends = false;       // the last
  std::uint32_t routine_cycles = 0;  // of the DSP, if it is trapped
  std::uint16_t contribution = 0;    // of the ray after it, as the sorter counts it
  Deposit deposit{};
  RayWay way{};
};

struct RayTrail {
  std::vector<TrailEvent> events;
  std::int32_t since = 0;  // steps since the last of them

  TrailEvent& add() {
    events.push_back({.steps = since});
    since = 0;
    return events.back();
  }
  // It ends where it is, with what it still contributes.
  void end(std::uint16_t contribution) {
    if (since > 0 || events.empty()) add();
    events.back().ends = true;
    events.back().contribution = contribution;
  }
};

// Where trails go to, one for each ray, and which samples of lighting rays write words though they deposit nothing.
struct TrailRecord {
  std::span<RayTrail> trails;
  bool visible_samples = false, all_samples = false;

  bool writes_all_voxels() const { return visible_samples || all_samples; }
};

}  // namespace gicube::emu
