#include "observe/breakpoints.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "cycle/machine_counters.h"

namespace gicube::emu {

namespace {

using Why = std::optional<std::string>;

[[noreturn]] void refuse(std::string_view expected, std::string_view got) {
  throw std::invalid_argument(fmt::format("expected {}, got \"{}\"", expected, got));
}

Picoseconds time_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const double ps = unit == "ps" ? 1 : unit == "ns" ? 1e3 : unit == "us" ? 1e6 : unit == "ms" ? 1e9 : 0;
  if (error != std::errc{} || ps == 0 || value < 0 || value * ps > 4e18)
    refuse("a time such as 12.5us (ps, ns, us, ms)", text);
  return static_cast<Picoseconds>(std::llround(value * ps));
}

// Returns the sum of a counter over the processors, or over the memories.
template <typename Parts, typename Counter>
std::uint64_t sum(const Parts& parts, const Counter& counter) {
  std::uint64_t out = 0;
  for (const auto& part : parts) out += counter(*part);
  return out;
}

std::uint64_t overflows(const Machine& machine) {
  return sum(machine.processors(), [](const Processor& part) { return part.sorter().counters().overflows; });
}
std::uint64_t conflicts(const Machine& machine) {
  return sum(machine.memories(), [](const auto& part) { return part.channel().counters().conflicts; });
}
std::uint64_t samples(const Machine& machine) {
  return sum(machine.processors(), [](const Processor& part) { return part.rays().samples; });
}

// Returns a condition that is met when `count` has grown. `what`: the reason that it reports.
auto grows(const char* what, std::uint64_t (*count)(const Machine&)) {
  return [what, count, before = std::optional<std::uint64_t>()](Cycle, const Machine& machine) mutable -> Why {
    const std::uint64_t now = count(machine);
    const bool has_grown = before && now > *before;
    before = now;
    return has_grown ? Why(what) : std::nullopt;
  };
}

Why over(const std::string& name, std::uint64_t value, const std::vector<wire::Counter>& counters) {
  for (const wire::Counter& each : counters) {
    if (each.name == name && each.value >= value) return fmt::format("{} is {}", name, each.value);
  }
  return std::nullopt;
}

bool all_rays(std::uint64_t, const wire::Ray&) { return true; }

// Breakpoint at each ray that `watches` selects, when the DSP makes it.
Breakpoint of_rays(std::function<bool(std::uint64_t, const wire::Ray&)> watches) {
  Breakpoint out;
  out.watches = std::move(watches);
  out.on_ray = [mine = out.watches](const RayEvent& event, const Machine&) -> Why {
    wire::Ray ray;
    ray.u = event.state->u;
    ray.v = event.state->v;
    if (event.step != RayStep::kMade || !mine(event.ray, ray)) return std::nullopt;
    return fmt::format("ray {} was made", event.ray);
  };
  return out;
}

Breakpoint at_position(const std::vector<std::string>& words, bool is_voxel) {
  std::array<std::uint64_t, 3> at{};
  for (std::size_t axis = 0; axis < 3; ++axis) at[axis] = number_at(words, axis + 1, "a coordinate");
  Breakpoint out;
  out.watches = all_rays;
  out.on_ray = [at, is_voxel](const RayEvent& event, const Machine& machine) -> Why {
    const bool is_iteration = event.step == RayStep::kSampled || event.step == RayStep::kLeapt;
    if (!is_iteration || (is_voxel && event.sample == nullptr)) return std::nullopt;
    std::uint64_t block = event.block;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto blocks = static_cast<std::uint64_t>(machine.blocks()[axis]);
      if (is_voxel) {
        const auto voxel = static_cast<std::uint64_t>(event.sample->position[axis] >> wire::kPositionFractionBits);
        if (at[axis] != voxel && at[axis] != voxel + 1) return std::nullopt;
      } else if (at[axis] != block % blocks) {
        return std::nullopt;
      }
      block /= blocks;
    }
    return fmt::format("ray {} {} {} {} {} at processor {}", event.ray,
                       is_voxel ? "reads voxel" : "passes through block", at[0], at[1], at[2], event.processor);
  };
  return out;
}

Breakpoint at_cycle(Cycle cycle) {
  Breakpoint out;
  out.cycle = cycle;
  out.on_cycle = [cycle](Cycle now, const Machine&) -> Why {
    return now >= cycle ? Why(fmt::format("cycle {}", now)) : std::nullopt;
  };
  return out;
}

Breakpoint at_fill(const std::vector<std::string>& words) {
  const std::uint64_t processor = number_at(words, 1, "a processor"), queue = number_at(words, 2, "a queue"),
                      fill = number_at(words, 3, "a number of rays");
  Breakpoint out;
  out.on_cycle = [processor, queue, fill](Cycle, const Machine& machine) -> Why {
    if (processor >= machine.processors().size()) return std::nullopt;
    if (queue >= queues_of(processor, machine)) return std::nullopt;
    const std::uint32_t waiting = machine.processors()[processor]->sorter().waiting(static_cast<std::uint32_t>(queue));
    if (waiting < fill) return std::nullopt;
    return fmt::format("queue {} of processor {} has {} rays", queue, processor, waiting);
  };
  return out;
}

}  // namespace

std::size_t queues_of(std::size_t processor, const Machine& machine) {
  return machine.has_single_queue() ? 1 : machine.partition().blocks_of(static_cast<unsigned>(processor));
}

std::uint64_t number_at(const std::vector<std::string>& words, std::size_t at, const char* what) {
  const std::string text = at < words.size() ? words[at] : "";
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) refuse(what, text);
  return value;
}

RayName ray_at(const std::vector<std::string>& words, std::size_t at) {
  const std::string text = at < words.size() ? words[at] : "";
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return {.number = number_at(words, at, "a ray's number, or ticket:number")};
  const std::vector<std::string> parts{text.substr(0, colon), text.substr(colon + 1)};
  const std::uint64_t ticket = number_at(parts, 0, "a ticket");
  if (ticket > std::numeric_limits<std::uint32_t>::max()) refuse("a ticket of 32 bits", parts[0]);
  return {static_cast<std::uint32_t>(ticket), number_at(parts, 1, "a ray's number")};
}

Breakpoint parse_breakpoint(const std::vector<std::string>& words, const CommandClock& clock) {
  const std::string kind = words.empty() ? "" : words[0];
  Breakpoint out;
  if (kind == "cycle") {
    out = at_cycle(number_at(words, 1, "a core cycle"));
  } else if (kind == "time") {
    const Picoseconds at = time_of(words.size() > 1 ? words[1] : "");
    if (at < clock.begin_ps)
      refuse(fmt::format("a time from {} ps on, the beginning of the command", clock.begin_ps), words[1]);
    const Picoseconds after = at - clock.begin_ps;
    constexpr Picoseconds kMillisecond = 1'000'000'000;
    out = at_cycle(clock.begin_cycle + after / kMillisecond * clock.core_khz +
                   after % kMillisecond * clock.core_khz / kMillisecond);
  } else if (kind == "ray") {
    const RayName name = ray_at(words, 1);
    out = of_rays([number = name.number](std::uint64_t ray, const wire::Ray&) { return ray == number; });
    out.ticket = name.ticket;
  } else if (kind == "pixel") {
    out = of_rays([x = number_at(words, 1, "a pixel's x"), y = number_at(words, 2, "a pixel's y")](
                      std::uint64_t, const wire::Ray& made) { return made.u >> 4 == x && made.v >> 4 == y; });
  } else if (kind == "voxel" || kind == "block") {
    out = at_position(words, kind == "voxel");
  } else if (kind == "queue") {
    out = at_fill(words);
  } else if (kind == "overflow") {
    out.on_cycle = grows("a queue overflowed", overflows);
  } else if (kind == "conflict") {
    out.on_cycle = grows("a packet had to close another row of its bank", conflicts);
  } else if (kind == "trap") {
    out.watches = all_rays;
    out.on_ray = [](const RayEvent& event, const Machine&) -> Why {
      if (event.step != RayStep::kScattered && event.step != RayStep::kWaits) return std::nullopt;
      return fmt::format("ray {} is trapped", event.ray);
    };
  } else if (kind == "counter") {
    const std::string name = words.size() > 1 ? words[1] : "";
    const std::uint64_t value = number_at(words, 2, "a counter's name and its value");
    out.on_counters = [name, value](const auto& counters) { return over(name, value, counters); };
    out.on_cycle = [name, value](Cycle, const Machine& machine) {
      std::vector<wire::Counter> counters;
      count(machine, counters);
      return over(name, value, counters);
    };
  } else if (kind == "command") {
    out.on_command = true;
  } else {
    refuse("cycle, time, ray, pixel, voxel, block, queue, overflow, trap, conflict, counter or command", kind);
  }
  for (const std::string& word : words) out.text += (out.text.empty() ? "" : " ") + word;
  return out;
}

Breakpoint step_of(const std::string& unit, std::uint64_t steps, Cycle now, const Machine& machine) {
  const auto after = [&machine, steps](auto sum, const char* what) {
    Breakpoint out;
    out.on_cycle = [sum, what, steps, target = sum(machine) + steps](Cycle, const Machine& seen) -> Why {
      return sum(seen) >= target ? Why(fmt::format("{} {} later", steps, what)) : std::nullopt;
    };
    return out;
  };
  if (unit == "cycle") return at_cycle(now + steps);
  if (unit == "sample") return after(samples, "samples");
  if (unit == "ray") return after([](const Machine& seen) { return seen.dsp().finished(); }, "finished rays");
  refuse("cycle, sample, ray or command", unit);
}

}  // namespace gicube::emu
