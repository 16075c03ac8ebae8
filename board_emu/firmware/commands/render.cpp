// The render command: renders an image into the framebuffer.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "command_fault.h"
#include "each_command.h"
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

}  // namespace

CommandResult RenderImage::run(Payload payload, Progress& work) {
  expect(payload.size() >= wire::kRenderCommandBytes, "payload", "at least 112 bytes", payload.size());
  const auto command = wire::decode<wire::RenderCommand>(payload);
  check_image(command, card_.config.dsp().framebuffer_mb());
  const std::vector<wire::Lamp> lamps = checked_lamps(command, payload.subspan(wire::kRenderCommandBytes));
  card_.check_volume();
  Frame frame = card_.frame();
  card_.check_materials(!frame.scatter || !card_.aperture.any_non_resident());
  frame.lamps = !lamps.empty();
  if (card_.goes_on) {
    expect(card_.aperture.framebuffer().is_of(command), "width, height, part", "those of the checkpoint's framebuffer",
           command.width);
  } else {
    card_.drop_rays();
    card_.waiting_rays.begin(WaitingKind::kPicture);
  }
  card_.set_bricks(frame);
  card_.expect_memory(frame, pixels_of(command));
  if (!card_.goes_on) card_.host_traps.begin(false, {});
  card_.aperture.decode(card_.threads, reads(frame));
  card_.lamps = Lamps(lamps, frame.spacing);
  const RunRules runs{card_.config.dsp().run_rays(), card_.config.dsp().run_error()};
  ImageRays rays(command, frame, card_.aperture.framebuffer(), runs, card_.lamps, card_.goes_on);
  const RunResult ran = card_.run_level(rays, frame, work);
  viewing_rays += rays.count();
  if (explained_) explain(command, frame);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  if (card_.waiting_rays.count() == 0) card_.aperture.resolve_framebuffer(card_.threads);
  card_.add_waiting(result);
  card_.add_trap_list(result, 0);
  return result;
}

}  // namespace gicube::emu
