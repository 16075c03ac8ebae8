#include "machine_counters.h"

#include <string>

#include "dsp/count_dsp.h"
#include "levels/counters.h"

namespace gicube::emu {

namespace {

constexpr std::size_t kActivationSizes = 21;  // powers of two: up to 2^21 rays issued while one queue is active

void put(PartCounters& part, const Processor& processor) {
  for (std::size_t i = 0; i < kCauses; ++i) {
    part.put("cycles." + std::string(kCauseNames[i]), "cycle", processor.causes()[i]);
  }
  part.put("samples", "sample", processor.rays().samples);
  part.put("rays_held", "cycle", processor.holding_cycles());
  const CacheCounters& cache = processor.cache().counters();
  part.put("cache.checks", "sample", cache.checks);
  part.put("cache.packets", "packet", cache.packets);
  part.put("cache.missed_voxels", "voxel", cache.missed_voxels);
  part.put("cache.filled_voxels", "voxel", cache.filled_voxels);
  for (std::size_t i = 0; i < cache.misses.size(); ++i) {
    part.put("cache.samples_with_misses." + std::to_string(i), "sample", cache.misses[i]);
  }
  const WriteCounters& writes = processor.writes().counters();
  part.put("splat.deposits", "deposit", processor.splats().counters().deposits);
  part.put("splat.carriers", "ray", processor.splats().counters().carriers);
  part.put("splat.tiles", "tile", writes.tiles);
  part.put("splat.tiles_combined", "tile", writes.combined);
  part.put("splat.tiles_fetched", "tile", writes.fetches);
  const SorterCounters& sorter = processor.sorter().counters();
  part.put("sorter.written", "ray", sorter.written);
  part.put("sorter.conflicts", "ray", sorter.conflicts);
  part.put("sorter.overflows", "ray", sorter.overflows);
  part.put("sorter.issued", "ray", sorter.issued);
  part.put("sorter.activations", "activation", sorter.activations);
  part.put("sorter.inserts", "insert", sorter.inserts);
  for (std::size_t i = 0; i < kActivationSizes; ++i) {
    part.put("sorter.activations_of_rays." + std::to_string(1u << i), "activation", sorter.activation_rays[i]);
  }
  for (std::size_t i = 0; i < kActivationSizes; ++i) {
    part.put("sorter.issued_in_activations_of_rays." + std::to_string(1u << i), "ray", sorter.activation_issued[i]);
  }
}

void put(PartCounters& part, const RingCounters& links) {
  part.put("rays_sent", "ray", links.sent);
  part.put("hops", "ray", links.hops());
  part.put("busy", "link cycle", links.busy);
  part.put("blocked", "link cycle", links.blocked);
  part.put("entry_waits", "cycle", links.entry_waits);
}

void put(PartCounters& part, const dram::ChannelCounters& memory, const char* clock, std::uint64_t cycles) {
  part.put("cycles", clock, cycles);
  part.put("reads", "packet", memory.packets_read);
  part.put("writes", "packet", memory.packets_written);
  part.put("row_hits", "packet", memory.row_hits);
  part.put("row_misses", "packet", memory.row_misses);
  part.put("row_conflicts", "packet", memory.conflicts);
  part.put("activates", "command", memory.activates);
  part.put("precharges", "command", memory.precharges);
  part.put("refreshes", "command", memory.refreshes);
  part.put("data_busy", clock, memory.dq_busy);
  part.put("turnaround", clock, memory.turnaround);
}

}  // namespace

RayCounters ray_counters(const Machine& machine) {
  RayCounters sum = machine.dsp().rays();
  for (const auto& processor : machine.processors()) sum += processor->rays();
  return sum;
}

void count(const Machine& machine, std::vector<wire::Counter>& list) {
  list.push_back({"asic.cycles", "cycle", machine.now()});
  {
    PartCounters part(list);
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      part.begin("processor", i);
      put(part, *machine.processors()[i]);
    }
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      part.begin("link", i);
      put(part, machine.links().counters(static_cast<std::uint32_t>(i)));
    }
    for (std::size_t i = 0; i < machine.memories().size(); ++i) {
      part.begin(machine.memory_standard().name, i);
      put(part, machine.memories()[i]->channel().counters(), machine.memory_standard().clock,
          machine.memories()[i]->cycles(machine.now()));
    }
  }
  list.push_back({"link.bisection_rays", "ray", machine.links().bisection_rays()});
  const RayBusCounters& bus = machine.ray_bus().counters();
  list.push_back({"ray_bus.rays", "ray", bus.rays});
  list.push_back({"ray_bus.runs", "run", bus.runs});
  list.push_back({"ray_bus.run_rays", "ray", bus.run_rays});
  list.push_back({"ray_bus.busy", "cycle", bus.busy});
  list.push_back({"ray_bus.waits", "cycle", bus.waits});
  const RayEngineCounters& dsp = machine.dsp().counters();
  list.push_back({"dsp.rays_sent", "ray", dsp.sent});
  list.push_back({"dsp.rays_taken", "ray", dsp.taken});
  list.push_back({"dsp.overflows", "ray", dsp.overflows});
  count_dsp(machine.dsp().dsp(), list);
  const std::vector<Machine::Millisecond>& milliseconds = machine.milliseconds();
  for (std::size_t ms = 0; ms < milliseconds.size(); ++ms) {
    list.push_back({"asic.block_loads.ms" + std::to_string(ms), "activation", milliseconds[ms].activations});
    list.push_back({"asic.samples.ms" + std::to_string(ms), "sample", milliseconds[ms].samples});
  }
}

MachineLook look(const Machine& machine) {
  MachineLook seen;
  seen.cycle = machine.now();
  const auto& blocks = machine.blocks();
  const auto cells = [&](std::size_t axis) {
    return (static_cast<std::uint32_t>(blocks[axis]) + seen.blocks_a_side - 1) / seen.blocks_a_side;
  };
  while (std::size_t{cells(0)} * cells(1) * cells(2) > MachineLook::kMaxCells) seen.blocks_a_side *= 2;
  seen.cells = {cells(0), cells(1), cells(2)};
  const bool by_block = !machine.has_single_queue();
  if (by_block) seen.waiting.resize(std::size_t{seen.cells[0]} * seen.cells[1] * seen.cells[2]);
  const std::size_t across = static_cast<std::size_t>(blocks[0]), down = static_cast<std::size_t>(blocks[1]);
  for (unsigned i = 0; i < machine.processors().size(); ++i) {
    const Sorter& sorter = machine.processors()[i]->sorter();
    seen.processors.push_back(static_cast<std::uint32_t>(sorter.waiting()));
    if (!by_block || sorter.waiting() == 0) continue;
    for (std::uint32_t queue = 0; queue < machine.partition().blocks_of(i); ++queue) {
      const std::size_t block = machine.partition().block(i, queue);
      const std::size_t x = block % across / seen.blocks_a_side, y = block / across % down / seen.blocks_a_side,
                        z = block / (across * down) / seen.blocks_a_side;
      seen.waiting[x + seen.cells[0] * (y + seen.cells[1] * z)] += sorter.waiting(queue);
    }
  }
  for (const auto& memory : machine.memories()) {
    seen.packets.push_back(memory->channel().bank_packets());
    seen.banks = static_cast<std::uint32_t>(seen.packets.back().size() / memory->devices());
  }
  return seen;
}

}  // namespace gicube::emu
