#include "hardware_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "asic/memory_standards.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

namespace {

constexpr std::uint64_t kRayBits = 8 * wire::kRayBytes;
constexpr std::uint64_t kGradientReaders = 8;     // one table for each voxel of a neighbourhood [P Table 1]
constexpr std::uint64_t kGradientBits = 3 * 10;   // [P Table 1]
constexpr std::uint64_t kSegmentationBits = 84;   // [P Table 1]
constexpr std::uint64_t kReflectanceBits = 8;     // [P Table 1]
constexpr std::uint64_t kOtherRegisters = 20;     // [P Table 1], which does not say what they hold
constexpr std::uint64_t kOtherRegisterBits = 55;  // [P Table 1]
constexpr std::uint64_t kKilobit = 1 << 10;
constexpr std::uint64_t kMegabit = 1 << 20;

CostItem ray_queues(const v1::BoardConfig& config) {
  const v1::AsicConfig& asic = config.asic();
  std::uint64_t queues = asic.processors();
  if (config.sorter().queues() != v1::single) {
    const std::uint64_t across = std::max(1u, asic.max_volume_voxels() / asic.block_voxels());
    queues = across * across * across;
  }
  return {fmt::format("{} x {} x {}", queues, asic.queue_rays(), kRayBits), queues * asic.queue_rays() * kRayBits};
}

}  // namespace

HardwareCost hardware_cost(const v1::BoardConfig& config) {
  const std::uint64_t p = config.asic().processors();
  const std::uint64_t edge = config.asic().block_voxels() + 1;
  const std::uint64_t stages = config.pipeline().prefetch_stages() + config.pipeline().compute_stages();
  constexpr std::uint64_t kFaces = wire::kReflectanceFaces, kSize = wire::kReflectanceSize;
  HardwareCost cost;
  cost.ray_queues = ray_queues(config);
  cost.volume_cache = {fmt::format("{} x {}^3 x {}", p, edge, wire::kVoxelBits),
                       p * edge * edge * edge * wire::kVoxelBits};
  cost.gradient_lut = {fmt::format("{} x {} x {} x {}", p, wire::kGradientCodes, kGradientReaders, kGradientBits),
                       p * wire::kGradientCodes * kGradientReaders * kGradientBits};
  cost.registers = {fmt::format("{} x {} + {} x {}", stages, kRayBits, kOtherRegisters, kOtherRegisterBits),
                    stages * kRayBits + kOtherRegisters * kOtherRegisterBits};
  cost.segmentation_lut = {fmt::format("{} x {} x {}", p, wire::kSegmentationEntries, kSegmentationBits),
                           p * wire::kSegmentationEntries * kSegmentationBits};
  cost.reflectance_map = {fmt::format("{} x {}^2 x {} x {}", p, kSize, kFaces, kReflectanceBits),
                          p * kSize * kSize * kFaces * kReflectanceBits};
  cost.sram = {fmt::format("with {} x registers", p), cost.volume_cache.bits + cost.gradient_lut.bits +
                                                          p * cost.registers.bits + cost.segmentation_lut.bits +
                                                          cost.reflectance_map.bits};
  const dram::Standard memory = memory_standard(config);
  cost.memory_signals = memory.signals;
  cost.memory_signal_count = memory.signal_count;
  cost.memory_channels = static_cast<std::uint32_t>((p + memory.sharing - 1) / memory.sharing);
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
  return text;
}

}  // namespace gicube::emu
