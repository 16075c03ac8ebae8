#include "config/energy.h"

#include <algorithm>
#include <array>
#include <map>
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
constexpr std::uint64_t kBitsOfTables = 8 * 30 + 84;  // gradients and a segmentation entry, per sample [P Table 1]
constexpr std::uint64_t kBitsOfReflection = 4 * 8;    // four texels per visible sample

// Parts of the card, in the order of the result.
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
  std::uint64_t percent = 0;  // uncertainty
};

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

// Everything that is constant while a board works.
struct EnergyModel::Prices {
  explicit Prices(const v1::BoardConfig& config);

  Price price(const std::string& field) const { return by_field.at(field); }

  std::map<std::string, Price> by_field;      // all fields of EnergyConfig
  std::string memory, bus_byte;               // prefix of the memory's fields and counters; field of the bus
  std::uint64_t channels, devices;            // devices of all channels: RDRAMs, or ranks
  std::uint64_t memory_khz, memory_interval;  // clocks between two refreshes
  std::uint64_t sdram_khz, sdram_interval, ranks;
  std::uint64_t dsp_khz, core_khz, link_bits;
  std::uint64_t voxel_bits, register_bits, sram_bits, edram_bits;
  // Transistors of one processor that are used by one event.
  std::uint64_t sample_logic, leap_logic, deposit_logic, light_logic, insert_logic, check_logic;
};

EnergyModel::Prices::Prices(const v1::BoardConfig& config) {
  const v1::EnergyConfig& energy = config.energy();
  for (int i = 0; i < energy.GetDescriptor()->field_count(); ++i) {
    const auto& field = *energy.GetDescriptor()->field(i);
    by_field[field.name()] = {energy.GetReflection()->GetUInt32(energy, &field),
                              field.options().GetExtension(v1::uncertainty)};
  }
  const bool is_ddr = config.memory() == v1::ddr;
  memory = is_ddr ? "ddr" : "rdram";
  bus_byte = config.bus().model() == v1::pci33 ? "pci_byte_fj" : "agp_byte_fj";
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
  dsp_khz = config.dsp().clock_khz();
  core_khz = config.asic().core_khz();
  link_bits = config.link().bits();

  const HardwareCost cost = hardware_cost(config);
  const auto format = static_cast<wire::VoxelFormat>(config.asic().voxel_format());
  voxel_bits = static_cast<std::uint64_t>(wire::voxel_bits(format, config.asic().irradiance_words()));
  register_bits = p * cost.registers.bits;
  for (const LogicItem& item : cost.logic) {
    if (std::string_view(item.part) == "Control") register_bits += item.count;
  }
  sram_bits = cost.sram.bits;
  edram_bits = cost.ray_queues.bits;
  const auto logic_of = [&](std::initializer_list<std::string_view> names) {
    std::uint64_t all = 0;
    for (const LogicItem& item : cost.logic) {
      if (std::ranges::find(names, item.name) != names.end()) all += item.transistors();
    }
    return all / p;
  };
  sample_logic = logic_of({"interpolators", "opacity correction", "reflectance", "shading", "compositing",
                           "steps and leaps", "interpolators of colours", "colours", "interpolators of irradiance"});
  leap_logic = logic_of({"steps and leaps"});
  deposit_logic = logic_of({"splats", "splats of green and blue"});
  light_logic = logic_of({"parts of lighting rays"});
  insert_logic = logic_of({"ranks of the sorters"});
  check_logic = logic_of({"comparators of eight voxels"});
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
  const auto price = [&of](const std::string& field) { return of.price(field); };
  const auto memory_price = [&of](const std::string& what) { return of.price(of.memory + "_" + what); };
  const auto memory_count = [&](const std::string& what) { return counted(of.memory + "." + what); };

  // Memory of the volume. All devices rest in standby. A device whose data is on the channel is in attention meanwhile.
  const std::uint64_t reads = memory_count("reads"), writes = memory_count("writes");
  const bool is_ddr = of.memory == "ddr";
  const Price standby = memory_price(is_ddr ? "rank_uw" : "standby_uw");
  sums[kMemory].power(standby, time * of.devices);
  if (!is_ddr) {
    const Price attention = price("rdram_attention_uw");
    sums[kMemory].power({attention.value - std::min(attention.value, standby.value), attention.percent},
                        Attojoules{memory_count("data_busy")} * kPsPerMs / of.memory_khz);
    sums[kMemoryInterface].power(price("rdram_interface_uw"), time * of.channels);
  }
  sums[kMemory].add(memory_count("activates"), memory_price("activate_fj"));
  sums[kMemory].add(reads, memory_price("read_fj"));
  sums[kMemory].add(writes, memory_price("write_fj"));
  if (of.memory_interval > 0)
    sums[kMemory].add(clocks(of.memory_khz) / of.memory_interval * of.devices, memory_price("refresh_fj"));
  sums[kMemoryInterface].add(Attojoules{reads} + writes, memory_price("io_fj"));

  // The DSP and its memory.
  const std::uint64_t bursts = counted("sdram.reads") + counted("sdram.writes");
  sums[kSdram].power(price("sdram_rank_uw"), time * of.ranks);
  sums[kSdram].add(counted("sdram.row_misses") + counted("sdram.row_conflicts"), price("sdram_activate_fj"));
  sums[kSdram].add(bursts, price("sdram_burst_fj"));
  sums[kSdram].add(bursts, price("sdram_io_fj"));
  if (of.sdram_interval > 0)
    sums[kSdram].add(clocks(of.sdram_khz) / of.sdram_interval * of.ranks, price("sdram_refresh_fj"));
  const Attojoules busy = std::min<Attojoules>(counted("dsp.busy_ps"), time);
  sums[kDsp].power(price("dsp_busy_uw_per_mhz"), busy * of.dsp_khz / 1000);
  sums[kDsp].power(price("dsp_idle_uw_per_mhz"), (time - busy) * of.dsp_khz / 1000);

  // The ASIC. A ray is written to its queue, and read from it.
  const Price sram = price("sram_bit_fj"), logic = price("logic_aj");
  const std::uint64_t samples = counted("processor.samples"), checks = counted("processor.cache.checks");
  const std::uint64_t deposits = counted("processor.splat.deposits"), tiles = counted("processor.splat.tiles");
  const Attojoules passes = Attojoules{counted("processor.sorter.written")} + counted("processor.sorter.issued");
  sums[kQueues].add(passes * wire::kRayBits, price("edram_bit_fj"));
  sums[kSorters].add(Attojoules{counted("processor.sorter.inserts")} * of.insert_logic, logic, 1);
  sums[kCache].add(Attojoules{checks} * 8 * of.voxel_bits, sram);
  sums[kCache].add(Attojoules{counted("processor.cache.packets") + tiles} * 4 * of.voxel_bits, sram);
  sums[kCache].add(Attojoules{checks} * of.check_logic, logic, 1);
  sums[kTables].add(Attojoules{samples} * kBitsOfTables, sram);
  sums[kTables].add(Attojoules{counted("pipeline.visible_samples")} * kBitsOfReflection, sram);
  sums[kPipelines].add(Attojoules{samples} * of.sample_logic, logic, 1);
  sums[kPipelines].add(Attojoules{counted("processor.cycles.leap")} * of.leap_logic, logic, 1);
  sums[kPipelines].add(Attojoules{deposits} * of.deposit_logic, logic, 1);
  sums[kPipelines].add(Attojoules{counted("pipeline.deposits")} * of.light_logic, logic, 1);
  sums[kLinks].add(Attojoules{counted("link.busy")} * of.link_bits, price("link_bit_fj"));
  sums[kRayBus].add(
      (Attojoules{counted("dsp.rays_sent")} + counted("dsp.rays_taken") + counted("dsp.overflows")) * wire::kRayBits,
      price("ray_bus_bit_fj"));
  sums[kClock].add(clocks(of.core_khz) * of.register_bits, price("clock_bit_fj"));
  sums[kLeakage].power(price("edram_uw_per_mbit"), time * of.edram_bits / kBitsPerMbit);
  sums[kLeakage].power(price("sram_uw_per_mbit"), time * of.sram_bits / kBitsPerMbit);
  sums[kHostBus].add(Attojoules{counted("bus.down.bytes")} + counted("bus.up.bytes"), of.price(of.bus_byte));

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
  sum.power(of->price("dsp_busy_uw_per_mhz"), Attojoules{busy} * of->dsp_khz / 1000);
  sum.power(of->price("dsp_idle_uw_per_mhz"), Attojoules{time - busy} * of->dsp_khz / 1000);
  return static_cast<std::uint64_t>(sum.value / kPj);
}

std::uint64_t EnergyModel::host_bus_pj(std::uint64_t bytes) const {
  const Prices* const of = prices();
  return of != nullptr ? static_cast<std::uint64_t>(Attojoules{bytes} * of->price(of->bus_byte).value * kFj / kPj) : 0;
}

std::vector<PartEnergy> EnergyModel::of_machine(const std::vector<wire::Counter>& counters) const {
  const Prices* const of = prices();
  if (of == nullptr) return {};
  Values counted(counters);
  counted.set("dsp.busy_ps", cycles_to_ps(counted("dsp.busy_cycles"), of->dsp_khz));
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
