#include "machine_counters.h"

#include <algorithm>
#include <map>
#include <string>

namespace gicube::emu {

namespace {

constexpr std::size_t kActivationSizes = 21;  // powers of two: up to 2^21 rays issued while one queue is active

// Writes each counter for one part, and adds it to the sum over all parts of its kind.
class Sums {
 public:
  explicit Sums(std::vector<wire::Counter>& list) : list_(list) {}

  void begin(std::string kind, std::size_t number) {
    flush(kind);
    kind_ = std::move(kind);
    prefix_ = kind_ + std::to_string(number) + '.';
    at_ = 0;
  }
  void put(const std::string& name, const char* unit, std::uint64_t value) {
    list_.push_back({prefix_ + name, unit, value});
    if (at_ == sums_.size()) sums_.push_back({kind_ + '.' + name, unit, 0});
    sums_[at_++].value += value;
  }
  ~Sums() { flush({}); }

 private:
  void flush(const std::string& next) {
    if (next == kind_) return;
    list_.insert(list_.end(), sums_.begin(), sums_.end());
    sums_.clear();
  }

  std::vector<wire::Counter>& list_;
  std::string kind_, prefix_;
  std::vector<wire::Counter> sums_;
  std::size_t at_ = 0;
};

void put(Sums& sums, const Processor& processor) {
  for (std::size_t i = 0; i < kCauses; ++i) {
    sums.put("cycles." + std::string(kCauseNames[i]), "cycle", processor.causes()[i]);
  }
  sums.put("samples", "sample", processor.rays().samples);
  sums.put("rays_held", "cycle", processor.holding_cycles());
  const CacheCounters& cache = processor.cache().counters();
  sums.put("cache.checks", "sample", cache.checks);
  sums.put("cache.packets", "packet", cache.packets);
  sums.put("cache.missed_voxels", "voxel", cache.missed_voxels);
  sums.put("cache.filled_voxels", "voxel", cache.filled_voxels);
  for (std::size_t i = 0; i < cache.misses.size(); ++i) {
    sums.put("cache.samples_with_misses." + std::to_string(i), "sample", cache.misses[i]);
  }
  const WriteCounters& writes = processor.writes().counters();
  sums.put("splat.deposits", "deposit", processor.splats().counters().deposits);
  sums.put("splat.carriers", "ray", processor.splats().counters().carriers);
  sums.put("splat.tiles", "tile", writes.tiles);
  sums.put("splat.tiles_combined", "tile", writes.combined);
  sums.put("splat.tiles_fetched", "tile", writes.fetches);
  const SorterCounters& sorter = processor.sorter().counters();
  sums.put("sorter.written", "ray", sorter.written);
  sums.put("sorter.conflicts", "ray", sorter.conflicts);
  sums.put("sorter.overflows", "ray", sorter.overflows);
  sums.put("sorter.issued", "ray", sorter.issued);
  sums.put("sorter.activations", "activation", sorter.activations);
  sums.put("sorter.inserts", "insert", sorter.inserts);
  for (std::size_t i = 0; i < kActivationSizes; ++i) {
    sums.put("sorter.activations_of_rays." + std::to_string(1u << i), "activation", sorter.activation_rays[i]);
  }
  for (std::size_t i = 0; i < kActivationSizes; ++i) {
    sums.put("sorter.issued_in_activations_of_rays." + std::to_string(1u << i), "ray", sorter.activation_issued[i]);
  }
}

void put(Sums& sums, const RingCounters& links) {
  sums.put("rays_sent", "ray", links.sent);
  sums.put("hops", "ray", links.hops());
  sums.put("busy", "link cycle", links.busy);
  sums.put("blocked", "link cycle", links.blocked);
  sums.put("entry_waits", "cycle", links.entry_waits);
}

void put(Sums& sums, const dram::ChannelCounters& memory, const char* clock, std::uint64_t cycles) {
  sums.put("cycles", clock, cycles);
  sums.put("reads", "packet", memory.packets_read);
  sums.put("writes", "packet", memory.packets_written);
  sums.put("row_hits", "packet", memory.row_hits);
  sums.put("row_misses", "packet", memory.row_misses);
  sums.put("row_conflicts", "packet", memory.conflicts);
  sums.put("activates", "command", memory.activates);
  sums.put("precharges", "command", memory.precharges);
  sums.put("refreshes", "command", memory.refreshes);
  sums.put("data_busy", clock, memory.dq_busy);
  sums.put("turnaround", clock, memory.turnaround);
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
    Sums sums(list);
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      sums.begin("processor", i);
      put(sums, *machine.processors()[i]);
    }
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      sums.begin("link", i);
      put(sums, machine.links().counters(static_cast<std::uint32_t>(i)));
    }
    for (std::size_t i = 0; i < machine.memories().size(); ++i) {
      sums.begin(machine.memory_standard().name, i);
      put(sums, machine.memories()[i]->channel().counters(), machine.memory_standard().clock,
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
  list.push_back({"dsp.busy_cycles", "DSP cycle", dsp.busy_cycles});
  const std::vector<Machine::Millisecond>& milliseconds = machine.milliseconds();
  for (std::size_t ms = 0; ms < milliseconds.size(); ++ms) {
    list.push_back({"asic.block_loads.ms" + std::to_string(ms), "activation", milliseconds[ms].activations});
    list.push_back({"asic.samples.ms" + std::to_string(ms), "sample", milliseconds[ms].samples});
  }
}

}  // namespace gicube::emu
