#include "observe/machine_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "observe/breakpoints.h"

namespace gicube::emu {

namespace {

constexpr double kUnitsOfVoxel = wire::kVoxel;

std::string position_of(const Point& at) {
  return fmt::format("{:.4f} {:.4f} {:.4f}", at[0] / kUnitsOfVoxel, at[1] / kUnitsOfVoxel, at[2] / kUnitsOfVoxel);
}

// Returns the number at words[at]. Throws std::invalid_argument if it is not below `count`.
std::size_t below(const std::vector<std::string>& words, std::size_t at, const char* what, std::size_t count) {
  const std::uint64_t value = number_at(words, at, what);
  if (value >= count) throw std::invalid_argument(fmt::format("{}: expected 0 to {}, got {}", what, count - 1, value));
  return static_cast<std::size_t>(value);
}

std::string position_of_block(std::size_t block, const Machine& machine) {
  const auto across = static_cast<std::size_t>(machine.blocks()[0]),
             down = static_cast<std::size_t>(machine.blocks()[1]);
  return fmt::format("{} {} {}", block % across, block / across % down, block / (across * down));
}

std::string block_of(std::size_t processor, std::size_t queue, const Machine& machine) {
  if (machine.has_single_queue()) return "all blocks";
  const std::size_t block =
      machine.partition().block(static_cast<unsigned>(processor), static_cast<std::uint32_t>(queue));
  return "block " + position_of_block(block, machine);
}

std::string view_queues(const std::vector<std::string>& words, const Machine& machine) {
  const std::size_t processor = below(words, 1, "processor", machine.processors().size());
  const Sorter& sorter = machine.processors()[processor]->sorter();
  std::string out = fmt::format("processor {}: {} rays wait\n", processor, sorter.waiting());
  const bool is_one = words.size() > 2;
  const std::size_t count = queues_of(processor, machine), only = is_one ? below(words, 2, "queue", count) : 0;
  for (std::size_t queue = is_one ? only : 0; queue < (is_one ? only + 1 : count); ++queue) {
    const std::uint32_t waiting = sorter.waiting(static_cast<std::uint32_t>(queue));
    const bool is_active = sorter.has_active() && sorter.active() == queue;
    if (!is_one && waiting == 0 && !is_active) continue;
    out += fmt::format("  queue {}, {}: {} rays{}\n", queue, block_of(processor, queue, machine), waiting,
                       is_active ? ", active" : "");
  }
  return out;
}

std::string view_set(const std::vector<std::string>& words, std::size_t processor, const Machine& machine) {
  const VolumeCache& cache = machine.processors()[processor]->cache();
  if (cache.has_tags_of_voxels()) throw std::invalid_argument("set: expected cache.tags of tiles, got of_voxels");
  const std::size_t set = below(words, 3, "set", cache.sets());
  std::string out =
      fmt::format("processor {}, set {} of {}, most recently used first:\n", processor, set, cache.sets());
  for (std::size_t way = 0; way < cache.ways(); ++way) {
    const auto held = cache.way(set, way);
    out += held ? fmt::format("  way {}: block {}, tile {}{}\n", way, position_of_block(held->tile.block, machine),
                              held->tile.tile, held->is_changed ? ", changed" : "")
                : fmt::format("  way {}: empty\n", way);
  }
  return out;
}

std::string view_cache(const std::vector<std::string>& words, const Machine& machine) {
  const std::size_t processor = below(words, 1, "processor", machine.processors().size());
  if (words.size() > 2 && words[2] == "set") return view_set(words, processor, machine);
  std::array<std::size_t, 3> at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    at[axis] = below(words, axis + 2, "block", static_cast<std::size_t>(machine.blocks()[axis]));
  }
  const auto across = static_cast<std::size_t>(machine.blocks()[0]),
             down = static_cast<std::size_t>(machine.blocks()[1]);
  const auto block = static_cast<std::uint32_t>(at[0] + across * (at[1] + down * at[2]));
  const VolumeCache& cache = machine.processors()[processor]->cache();
  std::string out =
      fmt::format("processor {}, block {} {} {}: tiles in its cache or requested:", processor, at[0], at[1], at[2]);
  std::size_t held = 0;
  for (std::size_t tile = 0; tile < cache.tiles_of_block(); ++tile) {
    if (!cache.probe(block, static_cast<std::uint32_t>(tile))) continue;
    if (held++ < 32) out += fmt::format(" {}", tile);
  }
  return out + fmt::format("{}; {} of {}\n", held > 32 ? " ..." : "", held, cache.tiles_of_block());
}

std::string view_bank(const std::vector<std::string>& words, const Machine& machine) {
  const std::size_t memory = below(words, 1, "memory", machine.memories().size());
  const dram::Memory& channel = machine.memories()[memory]->channel();
  const std::vector<std::uint64_t> packets = channel.bank_packets();
  const std::size_t devices = channel.devices(), banks = packets.size() / devices;
  const std::size_t device = below(words, 2, "device", devices), bank = below(words, 3, "bank", banks);
  std::ostringstream out;
  out << "memory " << memory << ", device " << device << ", bank " << bank << ": " << packets[device * banks + bank]
      << " packets read and written\n";
  channel.dump(out);
  return out.str();
}

// A full FIFO blocks the part that pushes into it.
template <typename T>
bool is_full(const Fifo<T>& fifo) {
  return fifo.size() >= kFifoPlaces;
}

// States what the DSP does.
std::string dsp_in_words(Cycle now, const Machine& machine) {
  const RayEngine& dsp = machine.dsp();
  if (dsp.waits(now)) return fmt::format("DSP: waits for its SDRAM until cycle {}", dsp.free_at());
  if (dsp.busy(now)) return fmt::format("DSP: works on one ray until cycle {}", dsp.free_at());
  if (is_full(machine.down())) return "DSP: a ray waits for the ray bus";
  return dsp.has_rays_to_send() ? "DSP: has rays to send" : "DSP: has sent all rays, and waits for their return";
}

std::string path_up(Cycle now, const Machine& machine) {
  if (!is_full(machine.up())) return "merge tree: not blocked";
  return "merge tree: its output is full <- " + dsp_in_words(now, machine);
}

std::string sorter_in_words(Cycle now, std::size_t number, const Machine& machine) {
  const Processor& processor = *machine.processors()[number];
  if (is_full(processor.overflow)) {
    return fmt::format("sorter {}: an overflowed ray waits <- {}", number, path_up(now, machine));
  }
  return fmt::format("sorter {}: not blocked, accepts two rays per cycle, {} wait in its queues", number,
                     processor.sorter().waiting());
}

std::string ray_bus_in_words(Cycle now, const Machine& machine) {
  if (machine.down().empty()) return "ray bus: not blocked";
  const std::size_t to = machine.down().front().processor;
  if (!is_full(machine.processors()[to]->from_bus)) return fmt::format("ray bus: transfers a ray to processor {}", to);
  return fmt::format("ray bus: its first ray waits for processor {}, whose input is full <- {}", to,
                     sorter_in_words(now, to, machine));
}

std::string chain_of(Cycle now, std::size_t number, const Machine& machine) {
  const Processor& processor = *machine.processors()[number];
  std::string out =
      fmt::format("processor {} ({}): ", number, kCauseNames[static_cast<std::size_t>(processor.latest())]);
  switch (processor.latest()) {
    case Cause::kBusy:
    case Cause::kLeap: return out + "works";
    case Cause::kSplat:
      return out + fmt::format("a deposit <- memory writes, {} tiles wait", processor.writes().size());
    case Cause::kFill:
    case Cause::kMiss:
    case Cause::kBank:
    case Cause::kRefresh: {
      if (processor.misses().empty()) return out + "the packets arrived in this cycle";
      const Packet& packet = processor.misses().oldest();
      out += fmt::format(
          "its oldest sample waits for {} packets <- memory: tile {} of its block {}, requested in cycle {}",
          processor.stages().prefetching() > 0 ? processor.stages().oldest_prefetching().packets : 0, packet.tile,
          packet.block, packet.asked);
      if (packet.arrival == kNoCycle) return out + ", not sent yet";
      constexpr std::array kDelays{"the data wires", "its bank", "a refresh"};
      return out + fmt::format(", arrives in cycle {}, delayed by {}", packet.arrival,
                               kDelays[static_cast<std::size_t>(packet.delay)]);
    }
    case Cause::kLatency: return out + "all its rays are in its pipeline";
    case Cause::kSorter: return out + sorter_in_words(now, number, machine);
    case Cause::kLink: {
      if (processor.out_links.empty()) return out + "links";
      const std::size_t to = processor.out_links.front().processor;
      const Processor& there = *machine.processors()[to];
      out +=
          fmt::format("a ray for processor {} waits for a link, which each ray holds for {} cycles; {} rays on links",
                      to, machine.links().cycles_per_ray(), machine.links().inside());
      const bool is_held_up = is_full(there.from_left) || is_full(there.from_right);
      return is_held_up ? out + " <- " + sorter_in_words(now, to, machine) : out;
    }
    case Cause::kRayBus:
      if (is_full(processor.done)) return out + "a finished ray waits <- " + path_up(now, machine);
      return out + "has no ray <- " + ray_bus_in_words(now, machine);
    case Cause::kQueueEmpty: return out + "has no ray, but other processors have";
    case Cause::kDsp:
    case Cause::kSdram: return out + "has no ray <- " + dsp_in_words(now, machine);
  }
  return out;
}

}  // namespace

std::string why_nothing_moves(Cycle now, const Machine& machine) {
  std::string out;
  for (std::size_t i = 0; i < machine.processors().size(); ++i) out += chain_of(now, i, machine) + '\n';
  return out + path_up(now, machine) + '\n' + dsp_in_words(now, machine) + '\n';
}

std::string view_of(const std::vector<std::string>& words, const Machine& machine) {
  const std::string& what = words.at(0);
  if (what == "queue") return view_queues(words, machine);
  if (what == "cache") return view_cache(words, machine);
  if (what == "bank") return view_bank(words, machine);
  std::ostringstream out;
  if (what == "link") {
    machine.links().dump(out);
  } else {
    machine.dump(out);
  }
  return out.str();
}

std::string words_of(const RayUnderWay& ray) {
  const RayState& state = ray.ray_state;
  return fmt::format(
      "  position {}, step {}, block {}\n  pixel {:.2f} {:.2f}, colour {} {} {} of 4095, opacity {} of {}, lifetime "
      "{}, "
      "generation {}, flags 0x{:02x}\n",
      position_of(state.position), position_of(state.step), ray.block, state.u / 16.0, state.v / 16.0, state.colour[0],
      state.colour[1], state.colour[2], state.opacity, wire::kOpacityOne, state.lifetime, unsigned{state.generation},
      unsigned{state.flags});
}

std::string line_of(const RayEvent& event) {
  std::string out = fmt::format("  cycle {}: {}", event.cycle, kRayStepNames[static_cast<std::size_t>(event.step)]);
  if (event.is_carrier) out += " (a carrier)";
  if (event.processor >= 0) out += fmt::format(", processor {}", event.processor);
  using enum RayStep;
  if (event.step == kQueued || event.step == kIssued || event.step == kOverflowed)
    out += fmt::format(", queue {}", event.queue);
  if (event.step == kSampled && event.count > 0) out += fmt::format(", {} packets missing", event.count);
  if (event.step == kFilled) out += fmt::format(", the pipeline stalled for {} cycles", event.count);
  if (event.step == kLinked) out += fmt::format(", to processor {}", event.count);
  return out + '\n';
}

void set_word(const std::vector<std::string>& words, std::size_t at, RayUnderWay& ray) {
  const std::string name = at < words.size() ? words[at] : "";
  if (name == "opacity") {
    const std::uint64_t value = number_at(words, at + 1, "an opacity");
    if (value > wire::kOpacityOne) {
      throw std::invalid_argument(fmt::format("opacity: expected 0 to {}, got {}", wire::kOpacityOne, value));
    }
    ray.ray_state.opacity = static_cast<std::uint32_t>(value);
    ray.ray_state.wide.opacity = static_cast<float>(value) / static_cast<float>(wire::kOpacityOne);
    return;
  }
  if (name != "colour") throw std::invalid_argument(fmt::format("expected opacity or colour, got \"{}\"", name));
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t value = below(words, at + 1 + c, "colour", wire::kColourOne + 1);
    ray.ray_state.colour[c] = static_cast<std::uint16_t>(value);
    ray.ray_state.wide.colour[c] = static_cast<float>(value);
  }
}

}  // namespace gicube::emu
