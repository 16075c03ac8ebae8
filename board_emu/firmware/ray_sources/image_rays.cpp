#include "firmware/ray_sources/image_rays.h"

#include <algorithm>

#include "firmware/viewing_rays.h"

namespace gicube::emu {

namespace {

constexpr int kSubPixels = 16;  // u and v are 12.4 pixels
constexpr int kTile = 16;       // pixels an edge; chosen: the rays of a tile share the voxels that fit a core's cache

}  // namespace

ImageRays::ImageRays(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                     const v1::DspConfig& dsp)
    : command_(command),
      frame_(frame),
      framebuffer_(framebuffer),
      dsp_(dsp),
      across_(std::uint64_t{command.width} * command.samples_per_axis),
      spacing_(kSubPixels / command.samples_per_axis),
      tiles_across_((command.width + kTile - 1) / kTile) {
  framebuffer.clear(command.width, command.height, command.filter);
}

std::optional<wire::Ray> ImageRays::viewing_ray_at(std::uint16_t u, std::uint16_t v, wire::Ray& miss) const {
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

std::optional<wire::Ray> ImageRays::make(std::uint64_t i, RayCounters&) {
  const auto place = [this](std::uint64_t sample) {
    return static_cast<std::uint16_t>(sample * static_cast<unsigned>(spacing_) + static_cast<unsigned>(spacing_) / 2);
  };
  wire::Ray miss;
  const auto ray = viewing_ray_at(place(i % across_), place(i / across_), miss);
  if (!ray) framebuffer_.add(miss);
  return ray;
}

std::size_t ImageRays::divide(std::size_t) {
  return static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>((command_.height + kTile - 1) / kTile);
}

std::unique_ptr<RayBatch> ImageRays::make_batch(std::size_t b) {
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

void ImageRays::take_batch(RayBatch& batch) {
  for (const wire::Ray& ray : batch.rays) framebuffer_.add_alone(ray);
}

}  // namespace gicube::emu
