#include "observe/events.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace gicube::emu {

namespace {

template <typename From, typename To>
void copy(const From& from, To& to) {
  std::ranges::transform(from, to, [](auto word) { return static_cast<std::remove_reference_t<decltype(*to)>>(word); });
}

template <typename Words>
std::string list(const Words& words) {
  return fmt::format("[{},{},{}]", words[0], words[1], words[2]);
}

// In voxels.
template <typename Words>
std::string position_text(const Words& at) {
  constexpr double kVoxel = wire::kVoxel;
  return list(std::array{at[0] / kVoxel, at[1] / kVoxel, at[2] / kVoxel});
}

std::string block_text(std::size_t block, const std::array<std::uint32_t, 3>& blocks) {
  return fmt::format("[{},{},{}]", block % blocks[0], block / blocks[0] % blocks[1], block / blocks[0] / blocks[1]);
}

std::string pixel_text(const wire::Pixel& pixel) {
  return fmt::format("[{},{},{},{}]", pixel.red, pixel.green, pixel.blue, pixel.alpha);
}

std::string iteration_text(const RayIteration& iteration, const std::array<std::uint32_t, 3>& blocks) {
  std::string out = fmt::format(R"({{"position":{},"block":{},)", position_text(iteration.position),
                                block_text(iteration.block, blocks));
  if (iteration.skipped > 0) {
    out += fmt::format(R"("leap":{},)", iteration.skipped);
  } else {
    constexpr double kDensity = 1 << kDensityFractionBits;
    out += fmt::format(R"("density":{},"gradient":[{},{},{}],"tag":{},"entry":{},"colour":{},"opacity":{},)",
                       iteration.channels[0] / kDensity, iteration.channels[1], iteration.channels[2],
                       iteration.channels[3], iteration.tag, iteration.entry, list(iteration.colour), iteration.alpha);
    if (iteration.scattered) out += R"("scattered":true,)";
  }
  return out + fmt::format(R"("gathered":{{"colour":{},"opacity":{}}}}})", list(iteration.gathered), iteration.opacity);
}

}  // namespace

void Events::begins(Cycle /*now*/, Machine& /*machine*/) { ++runs_; }

Cycle Events::next(Cycle from) {
  const Cycle every = selection_.counters_every;
  if (every == 0) return kNoCycle;
  const Cycle at = (std::max(from, selection_.cycles.begin) + every - 1) / every * every;
  return selection_.cycles.has(at) ? at : kNoCycle;
}

void Events::see(Cycle now, const Machine& machine) {
  for (std::size_t i = 0; i < machine.processors().size(); ++i) {
    const Processor& processor = *machine.processors()[i];
    gicube_event out{};
    out.size = sizeof out;
    out.kind = GICUBE_EVENT_COUNTERS;
    out.processor = static_cast<std::int16_t>(i);
    out.cycle = now;
    out.run = runs_ - 1;
    out.values[0] = processor.rays().samples;
    out.values[1] = processor.causes()[static_cast<std::size_t>(Cause::kBusy)];
    out.values[2] = processor.sorter().waiting();
    take_(out);
  }
}

void Events::happened(const RayEvent& event, const Machine& machine) {
  if (!selection_.has(event)) return;
  gicube_event out{};
  out.size = sizeof out;
  out.kind = static_cast<std::uint16_t>(event.step);
  out.processor = static_cast<std::int16_t>(event.processor);
  out.cycle = event.cycle;
  out.ray = event.ray;
  out.count = event.count;
  out.run = runs_ - 1;
  out.queue = event.queue;
  const auto across = static_cast<std::uint32_t>(machine.blocks()[0]),
             slice = across * static_cast<std::uint32_t>(machine.blocks()[1]);
  out.block[0] = event.block % across;
  out.block[1] = event.block % slice / across;
  out.block[2] = event.block / slice;
  out.is_carrier = event.is_carrier ? 1 : 0;
  const RayState& ray = *event.state;
  out.u = ray.u;
  out.v = ray.v;
  copy(ray.position, out.position);
  copy(ray.colour, out.colour);
  out.opacity = ray.opacity;
  if (event.sample != nullptr) {
    const RaySample& sample = *event.sample;
    out.density = sample.density;
    copy(sample.gradient, out.gradient);
    out.tag = static_cast<std::uint16_t>(sample.tag);
    copy(sample.colour, out.sample_colour);
    out.end = static_cast<std::uint16_t>(sample.end);
    copy(sample.position, out.sample_position);
    out.sample_opacity = sample.opacity;
  }
  take_(out);
}

std::string to_json(const gicube_event& event) {
  std::string out;
  const auto add = [&out](auto text, const auto&... values) {
    fmt::format_to(std::back_inserter(out), fmt::runtime(text), values...);
  };
  if (event.kind == GICUBE_EVENT_COUNTERS) {
    add(R"({{"cycle":{},"event":"counters","run":{},"processor":{},"samples":{},"busy_cycles":{},"waiting":{}}})",
        event.cycle, event.run, event.processor, event.values[0], event.values[1], event.values[2]);
    return out;
  }
  add(R"({{"cycle":{},"event":"{}","run":{},"ray":{},"pixel":[{},{}])", event.cycle, kRayStepNames[event.kind],
      event.run, event.ray, event.u / 16.0, event.v / 16.0);
  if (event.processor >= 0) add(R"(,"processor":{},"queue":{})", event.processor, event.queue);
  add(R"(,"block":{},"count":{})", list(event.block), event.count);
  if (event.is_carrier != 0) add(R"(,"carrier":true)");
  if (event.kind == GICUBE_EVENT_SAMPLED && event.is_carrier == 0) {
    constexpr std::array kEnds{"", "left", "opaque", "absorbed", "waits"};
    add(R"(,"sample":{{"position":{},"density":{},"gradient":{},"tag":{},"colour":{},"opacity":{},"end":"{}"}})",
        position_text(event.sample_position), event.density / 8.0, list(event.gradient), event.tag,
        list(event.sample_colour), event.sample_opacity, kEnds[std::min<std::size_t>(event.end, kEnds.size() - 1)]);
  }
  add(R"(,"position":{},"colour":{},"opacity":{}}})", position_text(event.position), list(event.colour), event.opacity);
  return out;
}

std::string to_json(const PixelLife& life) {
  std::string out = fmt::format(R"({{"event":"life","pixel":[{},{}],)", life.x, life.y);
  if (!life.refused.empty()) return out + fmt::format(R"("refused":"{}"}})", life.refused);
  out += fmt::format(R"("framebuffer":{},"explained":{},"rays":[)", pixel_text(life.pixel), pixel_text(life.explained));
  for (const RayLife& ray : life.rays) {
    out += fmt::format(R"({}{{"ray":{},"at":[{},{}],"end":"{}","passes":[)", &ray == life.rays.data() ? "" : ",",
                       ray.number, ray.ray.u / 16.0, ray.ray.v / 16.0, ray.end);
    for (const RayIteration& iteration : ray.iterations) {
      out += (&iteration == ray.iterations.data() ? "" : ",") + iteration_text(iteration, life.blocks);
    }
    out += "]}";
  }
  return out + "]}";
}

}  // namespace gicube::emu
