// Rays under way at the approximate level, whose values are known: where each is, how it goes on, and what it meets.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "datapath/ray_step.h"
#include "functional/trail.h"
#include "levels/dsp_task.h"

namespace gicube::emu {

// What a ray that does more than gather meets.
struct PassRoute {
  std::vector<TrailEvent> events;
  std::size_t next = 0;  // of them
  bool carrier = false;  // an irradiance carrier
  DspTask looking;       // for lamps, when it comes back
};

// A ray under way. Of jittered rays `step` has the words from which each step is drawn. `rest`, `step_rest`: of the wide datapath
// (datapath/advance.h).
struct PassRay {
  Point position{};  // from its block's least corner
  Point step{};
  std::int32_t left = 0;  // steps to its end, or to its next event
  std::uint32_t block = 0;
  std::int32_t amount = 0;  // that each sample leaves in sums
  // What the ray contributes where it begins or after its last event, and so many steps later at the next; 12 bits.
  std::uint16_t contribution = 0, next_contribution = 0;
  std::int32_t steps = 0;
  Rest rest{}, step_rest{};
  std::unique_ptr<PassRoute> route{};  // null: it has no events but its end

  // So many steps are to its next event, after which it contributes that.
  void begin_way(std::int32_t steps_to_go, std::uint16_t contribution_then) {
    left = steps = steps_to_go;
    contribution = next_contribution;
    next_contribution = contribution_then;
  }
  // It goes on by `way`; its position is then the volume's.
  inline void follow(const RayWay& way, bool jitter);
};

// All rays under way, each in one place; what goes from part to part is its handle.
class PassRays {
 public:
  std::uint32_t add(PassRay&& ray) {
    if (free_.empty()) {
      free_.push_back(static_cast<std::uint32_t>(rays_.size()));
      rays_.emplace_back();
    }
    const std::uint32_t handle = free_.back();
    free_.pop_back();
    rays_[handle] = std::move(ray);
    return handle;
  }
  void remove(std::uint32_t handle) { free_.push_back(handle); }
  PassRay& operator[](std::uint32_t handle) { return rays_[handle]; }

 private:
  std::vector<PassRay> rays_;
  std::vector<std::uint32_t> free_;
};

// Direction, and place in the image: what a jittered step is drawn from.
inline Point drawn_from(const std::array<std::int16_t, 3>& direction, std::uint16_t u, std::uint16_t v) {
  return std::bit_cast<Point>(std::array<std::uint16_t, 6>{static_cast<std::uint16_t>(direction[0]),
                                                           static_cast<std::uint16_t>(direction[1]),
                                                           static_cast<std::uint16_t>(direction[2]), u, v, 0});
}

inline void PassRay::follow(const RayWay& way, bool jitter) {
  position = way.position;
  step = jitter ? drawn_from(way.direction, way.u, way.v) : way.step;
  rest = way.rest;
  step_rest = way.step_rest;
}

}  // namespace gicube::emu
