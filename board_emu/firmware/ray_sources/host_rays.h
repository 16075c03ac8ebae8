// Host rays in the DSP's memory. They are returned to their slots, or only deposit.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "firmware/viewing_rays.h"
#include "levels/ray_source.h"

namespace gicube::emu {

// A cut plane: two scalar products, a reciprocal and its product, and the remaining part of the ray.
inline constexpr DspLoop kCutHostRay{"cut plane of a host ray", 2 * 3 * 2 + 4 + 2, 2 * 8 + 8 + 6, 4};

// Writes the result for the host into the slot of its ray. The flags and the interaction value stay as the host sent
// them.
inline void put_back(const wire::Ray& ray, wire::Ray& place) {
  const std::uint8_t flags = place.flags;
  const std::uint16_t interaction = place.interaction;
  place = ray;
  place.flags = flags;
  place.interaction = interaction;
}

class HostRays : public RayByRaySource {
 public:
  // `come_back`: results are written to `rays`; otherwise their contents are undefined afterwards. A ray behind a cut
  // plane is unchanged. Both parameters must outlive this object.
  HostRays(std::span<wire::Ray> rays, const Frame& frame, bool come_back)
      : rays_(rays), frame_(frame), come_back_(come_back) {}

  std::uint64_t count() const override { return rays_.size(); }
  std::uint64_t max_under_way() const override { return kViewingRaysUnderWay; }
  DspTask making(std::uint64_t i) const override {
    DspTask task{.loop = &kPassRay,
                 .more_cycles = static_cast<std::uint32_t>(frame_.cut_planes.size()) * kCutHostRay.interval()};
    return task.with(in_batch(i, SdramUse::Kind::kRead));
  }
  DspTask taking(std::uint64_t i) const override {
    if (!come_back_) return {};
    return DspTask{.loop = &kPassRay}.with(in_batch(i, SdramUse::Kind::kWrite));
  }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override {
    wire::Ray& ray = rays_[i];
    if (!frame_.cut_planes.empty() && !enter(ray, frame_.extent, frame_.cut_planes)) return std::nullopt;
    if (frame_.lights()) count_emitted(unpack(ray, frame_), frame_, counters);
    return ray;
  }
  void take(std::uint64_t i, const wire::Ray& ray) override {
    if (come_back_) put_back(ray, rays_[i]);
  }

  void state(Archive::Record& record, std::uint64_t /*begin*/) override {
    for (wire::Ray& ray : rays_) {
      std::array<std::uint8_t, wire::kRayBytes> bytes{};
      wire::encode(ray, bytes);
      auto words = std::bit_cast<std::array<std::uint64_t, wire::kRayBytes / 8>>(bytes);
      record(words);
      bytes = std::bit_cast<decltype(bytes)>(words);
      if (record.loads()) ray = wire::decode<wire::Ray>(bytes);
    }
  }

  // Rays are traced in place, unless some do not enter or may wait.
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override {
    if (!frame_.cut_planes.empty() || frame_.in_bricks()) return RayByRaySource::make_batch(b);
    auto batch = std::make_unique<RayBatch>();
    const std::size_t begin = b * batch_rays_;
    batch->rays = rays_.subspan(begin, std::min(batch_rays_, rays_.size() - begin));
    for (std::size_t i = 0; frame_.lights() && i < batch->rays.size(); ++i) {
      count_emitted(unpack(batch->rays[i], frame_), frame_, batch->counters);
    }
    return batch;
  }
  void take_batch(RayBatch& batch) override {
    if (!batch.index.empty()) RayByRaySource::take_batch(batch);
  }

 protected:
  bool pays_for_misses() const override { return true; }

 private:
  std::span<wire::Ray> rays_;
  const Frame& frame_;
  bool come_back_;
};

}  // namespace gicube::emu
