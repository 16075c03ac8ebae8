// Event trace of rays that do more than gather, consumed by the timing models.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datapath/ray_step.h"
#include "words/words.h"

namespace gicube::emu {

// Position, step and direction of a ray.
struct RayWay {
  Point position{}, step{};
  Rest rest{}, step_rest{};  // wide datapath only
  std::array<std::int16_t, 3> direction{};
  std::uint16_t u = 0, v = 0;
};

inline RayWay way_of(const RayState& ray) {
  return {ray.position, ray.step, ray.rest, ray.step_rest, ray.direction, ray.u, ray.v};
}

struct TrailEvent {
  std::int32_t steps = 0;            // from the event before, or the start, to this event's sample, inclusive
  bool deposits = false;             // the sample writes words
  bool turns = false;                // the ray continues along `way`
  bool trapped = false;              // the ray goes to the DSP
  bool waits = false;                // it waits there for the host: this ray does not continue
  bool ends = false;                 // the last event
  std::uint32_t routine_cycles = 0;  // DSP cycles, if trapped
  std::uint16_t contribution = 0;    // the ray's, after the event, for the sorter
  Deposit deposit{};
  RayWay way{};
};

struct RayTrail {
  std::vector<TrailEvent> events;
  std::int32_t since = 0;  // steps since the last event

  TrailEvent& add() {
    events.push_back({.steps = since});
    since = 0;
    return events.back();
  }
  // Ends the trail at the present step, with the ray's remaining contribution.
  void end(std::uint16_t contribution) {
    if (since > 0 || events.empty()) add();
    events.back().ends = true;
    events.back().contribution = contribution;
  }
};

// Destination of trails, one per ray; and which samples of lighting rays write words even if they deposit nothing.
struct TrailRecord {
  std::span<RayTrail> trails;
  bool visible_samples = false, all_samples = false;

  bool writes_all_voxels() const { return visible_samples || all_samples; }
};

}  // namespace gicube::emu
