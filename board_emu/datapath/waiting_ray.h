// A rendering ray that waits for a block which is not on the card: all its bits, so that it goes on as if it had not waited.
#pragma once

#include <cstddef>
#include <cstdint>

#include "datapath/ray_step.h"

namespace gicube::emu {

struct WaitingRay {
  wire::Ray ray;
  WideWords wide{};  // of the wide datapath, as `rest`
  Rest rest{};
  std::uint32_t block = 0;
};

class WaitingRayQueue {
 public:
  virtual ~WaitingRayQueue() = default;
  // From several threads. Throws RoutineFault if there are too many.
  virtual void add(const WaitingRay& ray) = 0;
  // The ray of the command that has waited and has that (v, u); null: it sets out.
  virtual const WaitingRay* find(std::uint32_t id) const = 0;
};

// Whether a ray that comes to the block must wait.
inline bool is_absent(std::size_t block, const Frame& frame) {
  if (frame.absent.empty() || frame.absent[block] == 0) return false;
  return !frame.leap || frame.empty[block] == 0;
}

inline void wait_for(std::size_t block, const RayState& ray, const Frame& frame) {
  WaitingRay waiting;
  waiting.ray = pack(ray, frame);
  waiting.wide = ray.wide;
  waiting.rest = ray.rest;
  waiting.block = static_cast<std::uint32_t>(block);
  frame.waiting->add(waiting);
}

// unpack(), and what a ray that has waited has beyond its packet.
inline RayState unpack_or_continue(const wire::Ray& ray, const Frame& frame) {
  RayState out = unpack(ray, frame);
  if (!frame.wide || !frame.in_bricks()) return out;
  if (const WaitingRay* waited = frame.waiting->find(ray.host_id())) {
    out.wide = waited->wide;
    out.rest = waited->rest;
  }
  return out;
}

}  // namespace gicube::emu
