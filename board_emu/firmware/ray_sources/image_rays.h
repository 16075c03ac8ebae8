// The viewing rays of an image, which end in the framebuffer: rows of samples from the top, or tiles of pixels in batches.
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/framebuffer.h"
#include "firmware/viewing_rays.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/command.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class ImageRays : public RaySource {
 public:
  // Clears the framebuffer. All must outlive this.
  ImageRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer, const v1::DspConfig& dsp)
      : command_(command),
        frame_(frame),
        framebuffer_(framebuffer),
        dsp_(dsp),
        across_(std::uint64_t{command.width} * command.samples_per_axis),
        spacing_(kSubPixels / command.samples_per_axis),
        tiles_across_((command.width + kTile - 1) / kTile) {
    framebuffer.clear(command.width, command.height, command.filter);
  }

  std::uint64_t count() const override { return across_ * command_.height * command_.samples_per_axis; }
  std::uint64_t row_end(std::uint64_t i) const override { return (i / across_ + 1) * across_; }
  std::uint32_t make_cycles() const override { return dsp_.viewing_ray_cycles(); }
  std::uint32_t take_cycles() const override { return dsp_.returned_ray_cycles(); }

  std::optional<wire::Ray> make(std::uint64_t i, RayCounters&) override {
    const auto place = [this](std::uint64_t sample) {
      return static_cast<std::uint16_t>(sample * static_cast<unsigned>(spacing_) + static_cast<unsigned>(spacing_) / 2);
    };
    wire::Ray miss;
    const auto ray = viewing_ray_at(place(i % across_), place(i / across_), miss);
    if (!ray) framebuffer_.add(miss);
    return ray;
  }
  void take(std::uint64_t, const wire::Ray& ray) override { framebuffer_.add(ray); }

  std::size_t divide(std::size_t) override {
    return static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>((command_.height + kTile - 1) / kTile);
  }
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override {
    auto batch = std::make_unique<RayBatch>();
    const int left = static_cast<int>(b) % tiles_across_ * kTile, top = static_cast<int>(b) / tiles_across_ * kTile;
    const int right = std::min(left + kTile, int{command_.width}), bottom = std::min(top + kTile, int{command_.height});
    const int samples = command_.samples_per_axis;
    batch->room.reserve(static_cast<std::size_t>((right - left) * (bottom - top) * samples * samples));
    for (int v = top * kSubPixels + spacing_ / 2; v < bottom * kSubPixels; v += spacing_) {
      for (int u = left * kSubPixels + spacing_ / 2; u < right * kSubPixels; u += spacing_) {
        wire::Ray miss;
        const auto ray = viewing_ray_at(static_cast<std::uint16_t>(u), static_cast<std::uint16_t>(v), miss);
        if (ray) {
          batch->room.push_back(*ray);
        } else {
          framebuffer_.add_alone(miss);  // tiles share no pixel
        }
      }
    }
    batch->rays = batch->room;
    return batch;
  }
  void take_batch(RayBatch& batch) override {
    for (const wire::Ray& ray : batch.rays) framebuffer_.add_alone(ray);
  }

 private:
  static constexpr int kSubPixels = 16;  // u and v are 12.4 pixels
  static constexpr int kTile =
      16;  // pixels an edge; chosen: the rays of a tile share the voxels that fit a core's cache

  // The ray of a place of the image, 12.4 pixels; else `miss` is what the framebuffer gets for it.
  std::optional<wire::Ray> viewing_ray_at(std::uint16_t u, std::uint16_t v, wire::Ray& miss) const {
    const Line line = viewing_line(command_, u / double{kSubPixels}, v / double{kSubPixels});
    auto ray = viewing_ray(line, u, v, frame_.extent, frame_.cut_planes);
    if (ray) {
      ray->lifetime = frame_.lifetime;
    } else {
      miss.u = u;
      miss.v = v;
    }
    return ray;
  }

  const wire::RenderCommand& command_;
  const Frame& frame_;
  Framebuffer& framebuffer_;
  const v1::DspConfig& dsp_;
  std::uint64_t across_;  // rays in a row
  int spacing_;           // between samples, in sub-pixels
  int tiles_across_;
};

}  // namespace gicube::emu
