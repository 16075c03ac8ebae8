// The render command: renders an image into the framebuffer.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "command_fault.h"
#include "each_command.h"
#include "firmware/pixel_life.h"
#include "firmware/ray_sources/image_rays.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

namespace {

// Number of pixels that the card renders.
std::uint64_t pixels_of(const wire::RenderCommand& command) {
  return std::uint64_t{command.width} * static_cast<std::uint64_t>(ImageRows(command).count());
}

void check_image(const wire::RenderCommand& command, std::uint64_t framebuffer_mb) {
  expect(command.width >= 1 && command.width <= wire::kMaxImageSize, "width", "1..4095", command.width);
  expect(command.height >= 1 && command.height <= wire::kMaxImageSize, "height", "1..4095", command.height);
  expect(command.projection <= wire::Projection::kPerspective, "projection", "0 or 1",
         static_cast<std::uint64_t>(command.projection));
  const int samples = command.samples_per_axis;
  expect(samples == 1 || samples == 2 || samples == 4, "samples_per_axis", "1, 2 or 4", command.samples_per_axis);
  expect(command.filter <= wire::Filter::kTent, "filter", "0 or 1", static_cast<std::uint64_t>(command.filter));
  for (const auto* vector : {&command.origin, &command.forward, &command.du, &command.dv}) {
    if (!std::ranges::all_of(*vector, [](double x) { return std::isfinite(x); })) {
      refuse("origin, forward, du, dv: expected finite numbers");
    }
  }
  if (command.parts == 0) {
    expect(command.part == 0 && command.strip_rows == 0, "part, strip_rows", "0 of a whole picture", command.part);
  } else {
    expect(command.part < command.parts, "part", "less than parts", command.part);
    expect(command.strip_rows >= 1 && command.strip_rows <= command.height, "strip_rows", "1..height",
           command.strip_rows);
  }
  const std::uint64_t bytes = pixels_of(command) * Framebuffer::kBytesPerPixel;
  if (bytes > framebuffer_mb * 1'000'000) {
    refuse("width x height: expected an image whose sums fit dsp.framebuffer_mb = " + std::to_string(framebuffer_mb) +
           ", got " + std::to_string(bytes) + " bytes");
  }
}

std::vector<wire::Lamp> checked_lamps(const wire::RenderCommand& command, std::span<const std::uint8_t> records) {
  expect(command.lamps <= wire::kMaxLamps, "lamps", "0..32", command.lamps);
  if (records.size() != command.lamps * wire::kLampBytes) {
    refuse("payload", "112 + 88 bytes for each of its " + std::to_string(command.lamps) + " lamps",
           wire::kRenderCommandBytes + records.size());
  }
  std::vector<wire::Lamp> lamps;
  for (std::size_t i = 0; i < command.lamps; ++i) {
    lamps.push_back(wire::decode<wire::Lamp>(records.subspan(i * wire::kLampBytes)));
    check_part("lamp", i, [&] {
      if (const auto what = Lamps::fault(lamps.back())) refuse(*what);
    });
  }
  return lamps;
}

// Generates the pixel's rays again from the image's command, and traces them through the datapath.
void follow_pixel(Card& card, const wire::RenderCommand& command, const Frame& frame, PixelLife& life) {
  Framebuffer own;
  const RunRules runs{card.config.dsp().run_rays(), card.config.dsp().run_error()};
  ImageRays rays(command, frame, own, runs, card.lamps);
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
  life.pixel = card.aperture.framebuffer().pixel(life.x, life.y);
}

// Reports the rays of the pixel in card.explained, for an image that is in the framebuffer.
void explain(Card& card, const wire::RenderCommand& command, const Frame& frame) {
  PixelLife life;
  life.x = card.explained->x;
  life.y = card.explained->y;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    life.blocks[axis] = static_cast<std::uint32_t>(card.aperture.volume().blocks()[axis]);
  }
  if (life.x >= command.width || life.y >= command.height) {
    life.refused = "pixel: expected one of the picture's " + std::to_string(command.width) + " x " +
                   std::to_string(command.height) + ", got " + std::to_string(life.x) + "," + std::to_string(life.y);
  } else if (command.parts != 0) {
    life.refused = "picture: expected a whole one, got a part of one that several boards make";
  } else if (frame.in_bricks()) {
    life.refused = "volume: expected one that the card stores whole, got one in bricks";
  } else {
    follow_pixel(card, command, frame, life);
  }
  card.explained->report(life);
}

}  // namespace

CommandResult render_image(Card& card, Payload payload, Progress& work) {
  const auto command = header_of<wire::RenderCommand>(payload);
  check_image(command, card.config.dsp().framebuffer_mb());
  const std::vector<wire::Lamp> lamps = checked_lamps(command, payload.subspan(wire::kRenderCommandBytes));
  card.check_volume();
  Frame frame = card.frame();
  card.check_materials(!frame.scatter || !card.aperture.any_non_resident());
  frame.lamps = !lamps.empty();
  if (card.goes_on) {
    expect(card.aperture.framebuffer().is_of(command), "width, height, part", "those of the checkpoint's framebuffer",
           command.width);
  } else {
    card.drop_rays();
    card.waiting_rays.begin(WaitingKind::kPicture);
  }
  card.set_bricks(frame);
  card.expect_memory(frame, pixels_of(command));
  if (!card.goes_on) card.host_traps.begin(false, {});
  card.aperture.decode(card.threads, reads(frame));
  card.lamps = Lamps(lamps, frame.spacing);
  const RunRules runs{card.config.dsp().run_rays(), card.config.dsp().run_error()};
  ImageRays rays(command, frame, card.aperture.framebuffer(), runs, card.lamps, card.goes_on);
  const RunResult ran = card.run_level(rays, frame, work);
  card.viewing_rays += rays.count();
  if (card.explained) explain(card, command, frame);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  if (card.waiting_rays.count() == 0) card.aperture.resolve_framebuffer(card.threads);
  card.add_waiting(result);
  card.add_trap_list(result, 0);
  return result;
}

}  // namespace gicube::emu
