// The rays under way on the ASIC. FIFOs carry handles into this store, so that a ray's words stay in one slot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "datapath/ray_step.h"

namespace gicube::emu {

// Two cache lines of the host: most iterations start by missing the first, and only the wide datapath needs the second.
struct alignas(64) RayUnderWay {
  std::uint32_t block = 0;  // block of its position
  RayState ray_state;

  void state(Archive::Record& record) { record(block, ray_state); }
};
static_assert(offsetof(RayUnderWay, ray_state) + offsetof(RayState, wide) == 64);

class RayStore {
 public:
  std::uint32_t add(const RayUnderWay& ray) {
    if (free_.empty()) {
      rays_.push_back(ray);
      return static_cast<std::uint32_t>(rays_.size() - 1);
    }
    const std::uint32_t handle = free_.back();
    free_.pop_back();
    rays_[handle] = ray;
    return handle;
  }
  // References to rays stay valid while the next `count` are added.
  void make_room(std::size_t count) {
    if (rays_.capacity() - rays_.size() < count) rays_.reserve(2 * rays_.capacity() + count);
  }
  void remove(std::uint32_t handle) { free_.push_back(handle); }

  RayUnderWay& operator[](std::uint32_t handle) { return rays_[handle]; }
  const RayUnderWay& operator[](std::uint32_t handle) const { return rays_[handle]; }
  std::size_t handles() const { return rays_.size(); }
  void state(Archive& archive) {
    archive.list("rays", rays_);
    archive.list("free", free_, rays_.size());
    std::vector<bool> seen(rays_.size());
    for (const std::uint32_t handle : free_) {
      archive.expect(handle < rays_.size() && !seen[handle], "free", "unused handles, each once", handle);
      seen[handle] = true;
    }
  }
  std::size_t under_way() const { return rays_.size() - free_.size(); }
  // Whether each handle is in use.
  std::vector<bool> in_use() const {
    std::vector<bool> used(rays_.size(), true);
    for (const std::uint32_t handle : free_) used[handle] = false;
    return used;
  }

 private:
  std::vector<RayUnderWay> rays_;
  std::vector<std::uint32_t> free_;
};

}  // namespace gicube::emu
