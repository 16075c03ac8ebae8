// History of a pixel's rays: they are generated again from the image's command and traced through the datapath.
#include <algorithm>

#include "each_command.h"
#include "firmware/pixel_life.h"
#include "firmware/ray_sources/image_rays.h"

namespace gicube::emu {

void RenderImage::explain(const wire::RenderCommand& command, const Frame& frame) {
  PixelLife life;
  life.x = explained_->x;
  life.y = explained_->y;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    life.blocks[axis] = static_cast<std::uint32_t>(card_.aperture.volume().blocks()[axis]);
  }
  if (life.x >= command.width || life.y >= command.height) {
    life.refused = "pixel: expected one of the picture's " + std::to_string(command.width) + " x " +
                   std::to_string(command.height) + ", got " + std::to_string(life.x) + "," + std::to_string(life.y);
  } else if (command.parts != 0) {
    life.refused = "picture: expected a whole one, got a part of one that several boards make";
  } else if (frame.in_bricks()) {
    life.refused = "volume: expected one that the card stores whole, got one in bricks";
  } else {
    follow_pixel(command, frame, life);
  }
  explained_->report(life);
}

void RenderImage::follow_pixel(const wire::RenderCommand& command, const Frame& frame, PixelLife& life) {
  Framebuffer own;
  const RunRules runs{card_.config.dsp().run_rays(), card_.config.dsp().run_error()};
  ImageRays rays(command, frame, own, runs, card_.lamps);
  // The tent filter of a pixel extends to the centres of its neighbours.
  const int reach = command.filter == wire::Filter::kTent ? 1 : 0, samples = command.samples_per_axis;
  const auto first = [&](int at) { return std::max(at - reach, 0) * samples; };
  const auto last = [&](int at, int edge) { return std::min(at + reach + 1, edge) * samples; };
  const std::uint64_t across = std::uint64_t{command.width} * command.samples_per_axis;
  for (int row = first(life.y); row < last(life.y, command.height); ++row) {
    for (int column = first(life.x); column < last(life.x, command.width); ++column) {
      const std::uint64_t i = static_cast<std::uint64_t>(row) * across + static_cast<std::uint64_t>(column);
      RayCounters ignored;
      const auto ray = rays.make(i, ignored);
      RayLife followed;
      followed.end = "missed";
      if (ray) {
        followed = follow(*ray, frame);
        rays.take(i, followed.ray);
      }
      followed.number = i;
      life.rays.push_back(std::move(followed));
    }
  }
  life.explained = own.pixel(life.x, life.y);
  life.pixel = card_.aperture.framebuffer().pixel(life.x, life.y);
}

}  // namespace gicube::emu
