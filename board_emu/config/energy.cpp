#include "config/energy.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <unordered_map>

#include "asic/memory_standards.h"
#include "config/hardware_cost.h"
#include "gicube/v1/field_range.pb.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {
namespace {

// Sums of attojoules do not fit 64 bits: a card of 20 W takes 2^64 in a second.
__extension__ using Attojoules = unsigned __int128;

constexpr std::uint64_t kFj = 1000;       // attojoules
constexpr std::uint64_t kPj = 1'000'000;  // attojoules
constexpr std::uint64_t kPsPerMs = 1'000'000'000;
constexpr std::uint64_t kBitsPerMbit = 1 << 20;

// Parts of the card, by their places in the list of the result.
enum Part {
  kMemory,
  kMemoryInterface,
  kSdram,
  kDsp,
  kQueues,
  kSorters,
  kCache,
  kTables,
  kPipelines,
  kLinks,
  kRayBus,
  kClock,
  kLeakage,
  kHostBus,
  kParts
};
constexpr std::array<const char*, kParts> kNames{
    "memory", "memory_interface", "sdram", "dsp",     "queues", "sorters", "cache",
    "tables", "pipelines",        "links", "ray_bus", "clock",  "leakage", "host_bus"};

// A field of EnergyConfig.
struct Price {
  std::uint64_t value = 0;
  std::uint64_t percent = 0;  // by which it may be wrong
};

Price price(const v1::BoardConfig& config, const char* field_name) {
  const auto& energy = config.energy();
  const auto* field = energy.GetDescriptor()->FindFieldByName(field_name);
  return {energy.GetReflection()->GetUInt32(energy, field), field->options().GetExtension(v1::uncertainty)};
}

struct Sum {
  Attojoules value = 0, low = 0, high = 0;

  void add(Attojoules count, Price each, std::uint64_t unit = kFj) {
    const Attojoules all = count * each.value * unit;
    value += all;
    low += all * (100 - std::min<std::uint64_t>(each.percent, 100)) / 100;
    high += all * (100 + each.percent) / 100;
  }
  // A microwatt for a picosecond is an attojoule.
  void power(Price each, Attojoules ps) { add(ps, each, 1); }
};

std::uint64_t transistors(const std::vector<LogicItem>& items, std::string_view name) {
  std::uint64_t all = 0;
  for (const LogicItem& item : items) {
    if (name == item.name) all += item.transistors();
  }
  return all;
}

}  // namespace

class EnergyModel::Values {
 public:
  // Counters of a single part, as processor0.samples, are left out.
  explicit Values(const std::vector<wire::Counter>& counters) {
    for (const wire::Counter& each : counters) {
      const std::size_t dot = each.name.find('.');
      const bool is_of_one =
          dot != std::string::npos && dot > 0 && each.name[dot - 1] >= '0' && each.name[dot - 1] <= '9';
      if (!is_of_one) by_name_.emplace(each.name, each.value);
    }
  }
  std::uint64_t operator()(std::string_view name) const {
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? 0 : found->second;
  }
  void set(std::string_view name, std::uint64_t value) { by_name_[name] = value; }

 private:
  std::unordered_map<std::string_view, std::uint64_t> by_name_;
};

// All that does not change while a board works.
struct EnergyModel::Prices {
  explicit Prices(const v1::BoardConfig& config);

  bool is_ddr, is_agp;
  std::string memory;                         // the prefix of its counters
  std::uint64_t channels, devices;            // devices of all channels: RDRAMs, or ranks
  std::uint64_t memory_khz, memory_interval;  // clocks between two refreshes
  std::uint64_t sdram_khz, sdram_interval, ranks;
  std::uint64_t dsp_mhz_times_1000, core_khz, link_bits;
  std::uint64_t voxel_bits, table_bits, reflectance_bits, register_bits, sram_bits, edram_bits;
  // Transistors that work for one event, of one processor.
  std::uint64_t sample_logic, leap_logic, deposit_logic, light_logic, insert_logic, check_logic;

  Price standby, attention, activate, read, write, refresh, io, interface;
  Price sdram_rank, sdram_activate, sdram_burst, sdram_refresh, sdram_io;
  Price dsp_busy, dsp_idle, edram_bit, sram_bit, edram_rest, sram_rest, logic, clock_bit, link_bit, ray_bus_bit,
      bus_byte;
};

EnergyModel::Prices::Prices(const v1::BoardConfig& config) {
  const auto of = [&config](const char* name) { return price(config, name); };
  is_ddr = config.memory() == v1::ddr;
  is_agp = config.bus().model() != v1::pci33;
  memory = is_ddr ? "ddr." : "rdram.";
  const std::uint32_t p = config.asic().processors();
  const dram::Standard standard = memory_standard(config);
  const std::uint32_t sharing = std::min(standard.sharing, p);
  const std::uint32_t edge = config.asic().max_volume_voxels() / config.asic().block_voxels();
  channels = (p + sharing - 1) / sharing;
  const std::uint32_t blocks = (edge * edge * edge + p - 1) / p * sharing;
  devices = channels * make_memory(config, static_cast<std::uint32_t>(blocks_in_memory(config, blocks)))->devices();
  memory_khz = is_ddr ? config.ddr().clock_khz() : config.rdram().clock_khz();
  memory_interval = is_ddr ? config.ddr().refresh_interval() : config.rdram().refresh_interval();
  sdram_khz = config.sdram().clock_khz();
  sdram_interval = config.sdram().refresh_interval();
  ranks = config.sdram().ranks();
  dsp_mhz_times_1000 = config.dsp().clock_khz();
  core_khz = config.asic().core_khz();
  link_bits = config.link().bits();

  const HardwareCost cost = hardware_cost(config);
  const auto format = static_cast<wire::VoxelFormat>(config.asic().voxel_format());
  voxel_bits = static_cast<std::uint64_t>(wire::voxel_bits(format, config.asic().irradiance_words()));
  constexpr std::uint64_t kGradientBits = 8 * 30, kSegmentationBits = 84, kTexels = 4, kTexelBits = 8;  // [P Table 1]
  table_bits = kGradientBits + kSegmentationBits;
  reflectance_bits = kTexels * kTexelBits;
  register_bits = p * cost.registers.bits;
  for (const LogicItem& item : cost.logic) {
    if (std::string_view(item.part) == "Control") register_bits += item.count;
  }
  sram_bits = cost.sram.bits;
  edram_bits = cost.ray_queues.bits;
  const auto logic_of = [&](std::initializer_list<std::string_view> names) {
    std::uint64_t all = 0;
    for (const std::string_view name : names) all += transistors(cost.logic, name);
    return all / p;
  };
  sample_logic = logic_of({"interpolators", "opacity correction", "reflectance", "shading", "compositing",
                           "steps and leaps", "interpolators of colours", "colours", "interpolators of irradiance"});
  leap_logic = logic_of({"steps and leaps"});
  deposit_logic = logic_of({"splats", "splats of green and blue"});
  light_logic = logic_of({"parts of lighting rays"});
  insert_logic = logic_of({"ranks of the sorters"});
  check_logic = logic_of({"comparators of eight voxels"});

  standby = of(is_ddr ? "ddr_rank_uw" : "rdram_standby_uw");
  attention = is_ddr ? standby : of("rdram_attention_uw");
  activate = of(is_ddr ? "ddr_activate_fj" : "rdram_activate_fj");
  read = of(is_ddr ? "ddr_read_fj" : "rdram_read_fj");
  write = of(is_ddr ? "ddr_write_fj" : "rdram_write_fj");
  refresh = of(is_ddr ? "ddr_refresh_fj" : "rdram_refresh_fj");
  io = of(is_ddr ? "ddr_io_fj" : "rdram_io_fj");
  interface = is_ddr ? Price{} : of("rdram_interface_uw");
  sdram_rank = of("sdram_rank_uw");
  sdram_activate = of("sdram_activate_fj");
  sdram_burst = of("sdram_burst_fj");
  sdram_refresh = of("sdram_refresh_fj");
  sdram_io = of("sdram_io_fj");
  dsp_busy = of("dsp_busy_uw_per_mhz");
  dsp_idle = of("dsp_idle_uw_per_mhz");
  edram_bit = of("edram_bit_fj");
  sram_bit = of("sram_bit_fj");
  edram_rest = of("edram_uw_per_mbit");
  sram_rest = of("sram_uw_per_mbit");
  logic = of("logic_aj");
  clock_bit = of("clock_bit_fj");
  link_bit = of("link_bit_fj");
  ray_bus_bit = of("ray_bus_bit_fj");
  bus_byte = of(is_agp ? "agp_byte_fj" : "pci_byte_fj");
}

EnergyModel::EnergyModel(const v1::BoardConfig& config) : config_(config) {}
EnergyModel::~EnergyModel() = default;

const EnergyModel::Prices* EnergyModel::prices() const {
  if (config_.fidelity() != v1::cycle) return nullptr;
  std::call_once(priced_, [this] { prices_ = std::make_unique<const Prices>(config_); });
  return prices_.get();
}

std::vector<PartEnergy> EnergyModel::parts(const std::vector<wire::Counter>& counters, Picoseconds now) const {
  return prices() != nullptr ? parts_of(Values(counters), now) : std::vector<PartEnergy>();
}

std::vector<PartEnergy> EnergyModel::parts_of(const Values& counted, Picoseconds now) const {
  const Prices& of = *prices();
  std::array<Sum, kParts> sums;
  const Attojoules time = now;
  const auto clocks = [time](std::uint64_t khz) { return time * khz / kPsPerMs; };

  // Memory of the volume. All devices rest in standby; the one whose data pass is in attention meanwhile.
  const std::uint64_t reads = counted(of.memory + "reads"), writes = counted(of.memory + "writes");
  sums[kMemory].power(of.standby, time * of.devices);
  sums[kMemory].power({of.attention.value - std::min(of.attention.value, of.standby.value), of.attention.percent},
                      Attojoules{counted(of.memory + "data_busy")} * kPsPerMs / of.memory_khz);
  sums[kMemory].add(counted(of.memory + "activates"), of.activate);
  sums[kMemory].add(reads, of.read);
  sums[kMemory].add(writes, of.write);
  if (of.memory_interval > 0) sums[kMemory].add(clocks(of.memory_khz) / of.memory_interval * of.devices, of.refresh);
  sums[kMemoryInterface].add(Attojoules{reads} + writes, of.io);
  sums[kMemoryInterface].power(of.interface, time * of.channels);

  // The DSP and its memory.
  const std::uint64_t bursts = counted("sdram.reads") + counted("sdram.writes");
  sums[kSdram].power(of.sdram_rank, time * of.ranks);
  sums[kSdram].add(counted("sdram.row_misses") + counted("sdram.row_conflicts"), of.sdram_activate);
  sums[kSdram].add(bursts, of.sdram_burst);
  sums[kSdram].add(bursts, of.sdram_io);
  if (of.sdram_interval > 0) sums[kSdram].add(clocks(of.sdram_khz) / of.sdram_interval * of.ranks, of.sdram_refresh);
  const Attojoules busy = std::min<Attojoules>(counted("dsp.busy_ps"), time);
  sums[kDsp].power(of.dsp_busy, busy * of.dsp_mhz_times_1000 / 1000);
  sums[kDsp].power(of.dsp_idle, (time - busy) * of.dsp_mhz_times_1000 / 1000);

  // The ASIC. A ray is written to its queue, and read from it.
  const std::uint64_t samples = counted("processor.samples"), checks = counted("processor.cache.checks");
  const std::uint64_t deposits = counted("processor.splat.deposits"), tiles = counted("processor.splat.tiles");
  const Attojoules passes = Attojoules{counted("processor.sorter.written")} + counted("processor.sorter.issued");
  sums[kQueues].add(passes * wire::kRayBits, of.edram_bit);
  sums[kSorters].add(Attojoules{counted("processor.sorter.inserts")} * of.insert_logic, of.logic, 1);
  sums[kCache].add(Attojoules{checks} * 8 * of.voxel_bits, of.sram_bit);
  sums[kCache].add(Attojoules{counted("processor.cache.packets") + tiles} * 4 * of.voxel_bits, of.sram_bit);
  sums[kCache].add(Attojoules{checks} * of.check_logic, of.logic, 1);
  sums[kTables].add(Attojoules{samples} * of.table_bits, of.sram_bit);
  sums[kTables].add(Attojoules{counted("pipeline.visible_samples")} * of.reflectance_bits, of.sram_bit);
  sums[kPipelines].add(Attojoules{samples} * of.sample_logic, of.logic, 1);
  sums[kPipelines].add(Attojoules{counted("processor.cycles.leap")} * of.leap_logic, of.logic, 1);
  sums[kPipelines].add(Attojoules{deposits} * of.deposit_logic, of.logic, 1);
  sums[kPipelines].add(Attojoules{counted("pipeline.deposits")} * of.light_logic, of.logic, 1);
  sums[kLinks].add(Attojoules{counted("link.busy")} * of.link_bits, of.link_bit);
  sums[kRayBus].add(
      (Attojoules{counted("dsp.rays_sent")} + counted("dsp.rays_taken") + counted("dsp.overflows")) * wire::kRayBits,
      of.ray_bus_bit);
  sums[kClock].add(clocks(of.core_khz) * of.register_bits, of.clock_bit);
  sums[kLeakage].power(of.edram_rest, time * of.edram_bits / kBitsPerMbit);
  sums[kLeakage].power(of.sram_rest, time * of.sram_bits / kBitsPerMbit);
  sums[kHostBus].add(Attojoules{counted("bus.down.bytes")} + counted("bus.up.bytes"), of.bus_byte);

  std::vector<PartEnergy> parts;
  for (std::size_t i = 0; i < kParts; ++i) {
    const auto pj = [](Attojoules sum) { return static_cast<std::uint64_t>(sum / kPj); };
    parts.push_back({kNames[i], pj(sums[i].value), pj(sums[i].low), pj(sums[i].high)});
  }
  return parts;
}

std::uint64_t EnergyModel::dsp_pj(Picoseconds busy, Picoseconds time) const {
  const Prices* const of = prices();
  if (of == nullptr) return 0;
  Sum sum;
  sum.power(of->dsp_busy, Attojoules{busy} * of->dsp_mhz_times_1000 / 1000);
  sum.power(of->dsp_idle, Attojoules{time - busy} * of->dsp_mhz_times_1000 / 1000);
  return static_cast<std::uint64_t>(sum.value / kPj);
}

std::uint64_t EnergyModel::host_bus_pj(std::uint64_t bytes) const {
  const Prices* const of = prices();
  return of != nullptr ? static_cast<std::uint64_t>(Attojoules{bytes} * of->bus_byte.value * kFj / kPj) : 0;
}

std::vector<PartEnergy> EnergyModel::of_machine(const std::vector<wire::Counter>& counters) const {
  const Prices* const of = prices();
  if (of == nullptr) return {};
  Values counted(counters);
  counted.set("dsp.busy_ps", cycles_to_ps(counted("dsp.busy_cycles"), of->dsp_mhz_times_1000));
  counted.set("pipeline.visible_samples", counted("processor.samples"));
  counted.set("pipeline.deposits", counted("processor.splat.deposits"));
  counted.set("bus.down.bytes", 0);
  counted.set("bus.up.bytes", 0);
  return parts_of(counted, cycles_to_ps(counted("asic.cycles"), of->core_khz));
}

void EnergyModel::count(std::vector<wire::Counter>& counters, Picoseconds now) const {
  PartEnergy total{"total"};
  const auto put = [&counters](const PartEnergy& each) {
    const std::string name = std::string("energy.") + each.part;
    counters.push_back({name, "pJ", each.pj});
    counters.push_back({name + ".low", "pJ", each.low_pj});
    counters.push_back({name + ".high", "pJ", each.high_pj});
  };
  const std::vector<PartEnergy> all = parts(counters, now);
  for (const PartEnergy& each : all) {
    put(each);
    total += each;
  }
  if (!all.empty()) put(total);
}

}  // namespace gicube::emu
