// Rendering rays that wait in the DSP's memory for blocks which are not on the card.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "datapath/scattering.h"
#include "datapath/waiting_ray.h"
#include "gicube/archive.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

class WaitingRays : public WaitingRayQueue {
 public:
  static constexpr std::size_t kMax = std::size_t{1} << 24;  // chosen: 512 MB of packets in the DSP's SDRAM

  // Of the host's memory for each ray, at most: a growing list is there twice, the longer one half empty, and rays that go on are
  // there besides.
  static constexpr std::uint64_t kBytesOfRay = 4 * sizeof(WaitingRay);

  // So many bytes of the host's memory are left for rays.
  void set_room(std::uint64_t bytes) { max_ = std::min<std::uint64_t>(bytes / kBytesOfRay, kMax); }
  std::uint64_t memory_bytes() const { return (waiting_.capacity() + continued_.capacity()) * sizeof(WaitingRay); }

  // Forgets all rays.
  void begin() {
    waiting_ = {};
    continued_ = {};
    before_ = 0;
  }

  void add(const WaitingRay& ray) override {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= max_) {
      throw RoutineFault("more than " + std::to_string(max_) + " rays wait for blocks" +
                         (max_ < kMax ? ", for which memory is left (gicube-board --max-memory)" : "") +
                         ": a smaller image or fewer samples would help");
    }
    waiting_.push_back(ray);
  }

  // The others: between commands.
  // Takes those out whose blocks are no longer absent, by their (v, u), which no two rays of a picture share: so their order does
  // not depend on threads and time.
  std::span<const WaitingRay> take_ready(const Frame& frame) {
    const auto ready = std::partition(waiting_.begin(), waiting_.end(),
                                      [&frame](const WaitingRay& ray) { return is_absent(ray.block, frame); });
    continued_.assign(ready, waiting_.end());
    waiting_.erase(ready, waiting_.end());
    before_ = waiting_.size();
    std::ranges::sort(continued_, {}, id);
    return continued_;
  }
  // The same of the latest call.
  std::span<const WaitingRay> continued() const { return continued_; }
  const WaitingRay* find(std::uint32_t ray) const override {
    const auto at = std::ranges::lower_bound(continued_, ray, {}, id);
    return at != continued_.end() && id(*at) == ray ? &*at : nullptr;
  }
  std::size_t count() const { return waiting_.size(); }
  std::size_t added() const { return waiting_.size() - before_; }  // by the last command
  std::vector<wire::WaitingBlock> by_block() const {
    std::vector<std::uint32_t> blocks;
    for (const WaitingRay& ray : waiting_) blocks.push_back(ray.block);
    std::ranges::sort(blocks);
    std::vector<wire::WaitingBlock> out;
    for (const std::uint32_t block : blocks) {
      if (out.empty() || out.back().block != block) out.push_back({block, 0});
      ++out.back().rays;
    }
    return out;
  }
  // Of a volume with `blocks`, whose rays are in `extent`.
  void state(Archive& archive, std::size_t blocks, const Point& extent) {
    rays_state(archive, waiting_, blocks, extent);
    archive.at_most("before", before_, waiting_.size());
    archive.within("continued", [&] { rays_state(archive, continued_, blocks, extent); });
  }

 private:
  static void rays_state(Archive& archive, std::vector<WaitingRay>& rays, std::size_t blocks, const Point& extent) {
    std::vector<std::uint8_t> packets;
    for (const WaitingRay& each : rays) wire::append(packets, each.ray);
    archive.bytes("packets", packets, 0, kMax * wire::kRayBytes);
    if (archive.loads()) rays.resize(packets.size() / wire::kRayBytes);
    archive.field("beyond_packets", [&rays](Archive::Record& record) {
      for (WaitingRay& each : rays) record(each.wide.opacity, each.wide.colour, each.rest, each.block);
    });
    for (std::size_t i = 0; archive.loads() && i < rays.size(); ++i) {
      wire::Ray& ray = rays[i].ray;
      ray = wire::decode<wire::Ray>(std::span(packets).subspan(i * wire::kRayBytes));
      const Point at{static_cast<std::int32_t>(ray.position[0]), static_cast<std::int32_t>(ray.position[1]),
                     static_cast<std::int32_t>(ray.position[2])};
      archive.expect(inside(at, extent) && rays[i].block < blocks, "packets", "rays in the volume", i);
    }
  }
  static std::uint32_t id(const WaitingRay& ray) { return ray.ray.host_id(); }

  std::mutex mutex_;  // of waiting_
  std::vector<WaitingRay> waiting_;
  std::vector<WaitingRay> continued_;  // of the command in work
  std::size_t before_ = 0;             // rays that wait on
  std::size_t max_ = kMax;             // rays
};

}  // namespace gicube::emu
