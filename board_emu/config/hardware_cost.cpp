#include "hardware_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "asic/memory_standards.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

namespace {

constexpr std::uint64_t kGradientReaders = 8;     // one table for each voxel of a neighbourhood [P Table 1]
constexpr std::uint64_t kGradientBits = 3 * 10;   // [P Table 1]
constexpr std::uint64_t kSegmentationBits = 84;   // [P Table 1]
constexpr std::uint64_t kReflectanceBits = 8;     // [P Table 1]
constexpr std::uint64_t kOtherRegisters = 20;     // [P Table 1]; the paper does not state their contents
constexpr std::uint64_t kOtherRegisterBits = 55;  // [P Table 1]
constexpr std::uint64_t kKilobit = 1 << 10;
constexpr std::uint64_t kMegabit = 1 << 20;

struct Factor {
  std::uint64_t base;
  int power = 1;
};

CostItem product(std::initializer_list<Factor> factors) {
  CostItem item{"", 1};
  for (const auto& [base, power] : factors) {
    item.formula += (item.formula.empty() ? "" : " x ") + std::to_string(base);
    if (power > 1) item.formula += "^" + std::to_string(power);
    for (int i = 0; i < power; ++i) item.bits *= base;
  }
  return item;
}

std::uint64_t queues(const v1::BoardConfig& config) {
  const v1::AsicConfig& asic = config.asic();
  if (config.sorter().queues() == v1::single) return asic.processors();
  const std::uint64_t across = std::max(1u, asic.max_volume_voxels() / asic.block_voxels());
  return across * across * across;
}

}  // namespace

HardwareCost hardware_cost(const v1::BoardConfig& config) {
  const std::uint64_t p = config.asic().processors();
  const std::uint64_t edge = config.asic().block_voxels() + 1;
  const std::uint64_t stages = config.pipeline().prefetch_stages() + config.pipeline().compute_stages();
  const CostItem rays = product({{stages}, {wire::kRayBits}}),
                 others = product({{kOtherRegisters}, {kOtherRegisterBits}});
  HardwareCost cost;
  cost.ray_queues = product({{queues(config)}, {config.asic().queue_rays()}, {wire::kRayBits}});
  const auto format = static_cast<wire::VoxelFormat>(config.asic().voxel_format());
  cost.volume_cache = product(
      {{p}, {edge, 3}, {static_cast<std::uint64_t>(wire::voxel_bits(format, config.asic().irradiance_words()))}});
  cost.gradient_lut = product({{p}, {wire::kGradientCodes}, {kGradientReaders}, {kGradientBits}});
  cost.registers = {rays.formula + " + " + others.formula, rays.bits + others.bits};
  cost.segmentation_lut = product({{p}, {wire::kSegmentationEntries}, {kSegmentationBits}});
  cost.reflectance_map = product({{p}, {wire::kReflectanceSize, 2}, {wire::kReflectanceFaces}, {kReflectanceBits}});
  cost.sram = {fmt::format("with {} x registers", p), cost.volume_cache.bits + cost.gradient_lut.bits +
                                                          p * cost.registers.bits + cost.segmentation_lut.bits +
                                                          cost.reflectance_map.bits};
  const dram::Standard memory = memory_standard(config);
  cost.memory_signals = memory.signals;
  cost.memory_signal_count = memory.signal_count;
  cost.memory_channels = static_cast<std::uint32_t>((p + memory.sharing - 1) / memory.sharing);
  cost.logic = logic_cost(config);
  return cost;
}

std::string paper_units(std::uint64_t bits) {
  const std::uint64_t unit = bits < kMegabit ? kKilobit : kMegabit;
  const std::uint64_t tenths = (bits * 10 + unit / 2) / unit;
  return fmt::format("{}.{} {}", tenths / 10, tenths % 10, unit == kKilobit ? "Kb" : "Mb");
}

std::string to_string(const HardwareCost& cost) {
  std::string text = "Memories on the ASIC after Table 1 of the paper (Kb = 2^10 bit, Mb = 2^20 bit)\n\n";
  const auto line = [&text](std::string_view name, const CostItem& item, std::string_view kind) {
    text +=
        fmt::format("{:<28}{:<20}{:>12} bit  {:>9} {}\n", name, item.formula, item.bits, paper_units(item.bits), kind);
  };
  line("Ray queues", cost.ray_queues, "eDRAM");
  line("Volume cache", cost.volume_cache, "SRAM");
  line("Gradient LUT", cost.gradient_lut, "SRAM");
  line("Registers, each processor", cost.registers, "SRAM");
  line("Segmentation LUT", cost.segmentation_lut, "SRAM");
  line("Reflectance map", cost.reflectance_map, "SRAM");
  line("Total SRAM", cost.sram, "SRAM");
  line("Total eDRAM", {"", cost.ray_queues.bits}, "eDRAM");
  text += fmt::format("\nMemory signals: {} channels x {} = {} pins; each {}\n", cost.memory_channels,
                      cost.memory_signal_count, cost.memory_channels * cost.memory_signal_count, cost.memory_signals);
  return text + "\nLogic; how it is counted: docs/guide/observation.md\n\n" + to_string(cost.logic);
}

}  // namespace gicube::emu
