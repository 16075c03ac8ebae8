#include "observe/events.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace gicube::emu {

namespace {

constexpr double kVoxel = wire::kVoxel;

template <typename From, typename To>
void copy(const From& from, To& to) {
  std::ranges::transform(from, to, [](auto word) { return static_cast<std::remove_reference_t<decltype(*to)>>(word); });
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
  const auto position = [](const std::int32_t(&at)[3]) {
    return fmt::format("[{},{},{}]", at[0] / kVoxel, at[1] / kVoxel, at[2] / kVoxel);
  };
  if (event.kind == GICUBE_EVENT_COUNTERS) {
    add(R"({{"cycle":{},"event":"counters","run":{},"processor":{},"samples":{},"busy_cycles":{},"waiting":{}}})",
        event.cycle, event.run, event.processor, event.values[0], event.values[1], event.values[2]);
    return out;
  }
  add(R"({{"cycle":{},"event":"{}","run":{},"ray":{},"pixel":[{},{}])", event.cycle, kRayStepNames[event.kind],
      event.run, event.ray, event.u / 16.0, event.v / 16.0);
  if (event.processor >= 0) add(R"(,"processor":{},"queue":{})", event.processor, event.queue);
  add(R"(,"block":[{},{},{}],"count":{})", event.block[0], event.block[1], event.block[2], event.count);
  if (event.is_carrier != 0) add(R"(,"carrier":true)");
  if (event.kind == GICUBE_EVENT_SAMPLED && event.is_carrier == 0) {
    constexpr std::array kEnds{"", "left", "opaque", "absorbed", "waits"};
    add(R"(,"sample":{{"position":{},"density":{},"gradient":[{},{},{}],"tag":{},)"
        R"("colour":[{},{},{}],"opacity":{},"end":"{}"}})",
        position(event.sample_position), event.density / 8.0, event.gradient[0], event.gradient[1], event.gradient[2],
        event.tag, event.sample_colour[0], event.sample_colour[1], event.sample_colour[2], event.sample_opacity,
        kEnds[std::min<std::size_t>(event.end, kEnds.size() - 1)]);
  }
  add(R"(,"position":{},"colour":[{},{},{}],"opacity":{}}})", position(event.position), event.colour[0],
      event.colour[1], event.colour[2], event.opacity);
  return out;
}

}  // namespace gicube::emu
