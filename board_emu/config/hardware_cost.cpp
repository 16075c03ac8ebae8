#include "hardware_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <string_view>

#include "asic/fifo_places.h"
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

// Blocks of the largest volume.
std::uint64_t blocks(const v1::BoardConfig& config) {
  const std::uint64_t across = std::max(1u, config.asic().max_volume_voxels() / config.asic().block_voxels());
  return across * across * across;
}

std::uint64_t queues(const v1::BoardConfig& config) {
  return config.sorter().queues() == v1::single ? config.asic().processors() : blocks(config);
}

// ---- logic

using Count = std::uint64_t;

constexpr Count kSram = 6, kAdder = 28, kAnd = 6, kRegister = 24, kMultiplexer = 12, kRom = 1;

constexpr Count multiplier(Count a, Count b) { return a * b * (kAnd + kAdder); }
constexpr Count divider(Count quotient, Count divisor) { return quotient * divisor * (kAdder + kMultiplexer); }
// a + (b - a) w for the pipeline's words (words/words.h).
constexpr Count kInterpolator = multiplier(16, 15) + 2 * 16 * kAdder;
constexpr Count kTrilinear = 7;         // interpolators per channel [P §3.4]
constexpr Count kChannels = 4 + 1;      // density, gradient, irradiance
constexpr Count kFifosOfProcessor = 9;  // FIFOs of whole rays, in cycle/processor.h

// Logic of one processor's pipeline (datapath/).
constexpr Count kOpacity = multiplier(15, 6) + multiplier(28, 20) +
                           multiplier(14, 14) +  // two tables of slopes, the power between
                           5 * 24 * kMultiplexer + 2 * 1024 * 24 * kRom;
constexpr Count kReflectance =
    2 * divider(16, 17) + 3 * multiplier(9, 8) + 3 * multiplier(17, 17);  // face, map, length of the normal
constexpr Count kShade = multiplier(8, 15) + 3 * multiplier(12, 18) + 3 * 18 * kAdder +  // colour, highlight
                         multiplier(15, 16) + multiplier(31, 32);  // irradiance by gain and exposure
constexpr Count kOver = multiplier(24, 24) + 3 * multiplier(12, 24) + 4 * 24 * kAdder;
constexpr Count kStep = 3 * multiplier(16, 24) + (3 + 6) * 24 * kAdder;  // three axes; six faces to compare with
constexpr Count kTint = 3 * multiplier(12, 12);                          // multiplication by the LUT's colour
constexpr Count kPremultiply = 8 * 3 * multiplier(8, 12) + 3 * divider(12, 15);  // eight voxels, and back at the sample
constexpr Count kSkip = 3 * divider(10, 24);
constexpr Count kSplit = 4 * multiplier(14, 14) + 8 * multiplier(28, 14) + 8 * multiplier(12, 28);  // weights, shares
constexpr Count kPart = 2 * kTrilinear * kInterpolator + divider(24, 24);                           // for lighting rays

// The single queue of [P §5.1] needs no sorter.
void add_queues(std::vector<LogicItem>& items, const v1::BoardConfig& config) {
  const Count count = queues(config);
  const Count pointer = std::bit_width(config.asic().queue_rays() - 1u), number = std::bit_width(count - 1);
  const Count item = number + pointer + 1;  // a queue and its importance
  // Two buffers per rank. Each selects its own item, the other's, or the neighbour's above or below.
  if (config.sorter().queues() != v1::single)
    items.push_back({"Queues", "ranks of the sorters", count, item * (2 * kRegister + kAdder + 4 * kMultiplexer)});
  // Read and write positions, and the number of rays.
  items.push_back({"Queues", "pointers", count, (3 * pointer + 1) * (kRegister + kAdder)});
}

void add_cache(std::vector<LogicItem>& items, const v1::BoardConfig& config) {
  const Count processors = config.asic().processors(), edge = config.asic().block_voxels() / 2 + 1;
  const Count tag = std::bit_width(blocks(config) - 1) + 1;  // a block, or none
  items.push_back(
      {"Volume cache", "bits of tags", processors * edge * edge * (config.asic().block_voxels() + 1) * tag, kSram});
  items.push_back(
      {"Volume cache", "comparators of eight voxels", processors * 8 * config.cache().ways(), tag * kAdder});
}

std::vector<LogicItem> logic_cost(const v1::BoardConfig& config) {
  const Count processors = config.asic().processors();
  std::vector<LogicItem> items;
  add_queues(items, config);
  add_cache(items, config);
  items.insert(items.end(), {{"Pipeline", "interpolators", processors * kTrilinear * kChannels, kInterpolator},
                             {"Pipeline", "opacity correction", processors, kOpacity},
                             {"Pipeline", "reflectance", processors, kReflectance},
                             {"Pipeline", "shading", processors, kShade},
                             {"Pipeline", "compositing", processors, kOver},
                             {"Pipeline", "steps and leaps", processors, kStep + kSkip},
                             {"Pipeline", "splats", processors, kSplit},
                             {"Pipeline", "parts of lighting rays", processors, kPart}});
  const auto format = static_cast<wire::VoxelFormat>(config.asic().voxel_format());
  if (wire::has_colours(format)) {
    const Count alpha = format == wire::VoxelFormat::kRgba ? 1 : 0;
    items.push_back({"Pipeline", "interpolators of colours", processors * kTrilinear * 3, kInterpolator});
    items.push_back({"Pipeline", "colours", processors, kTint + alpha * kPremultiply});
  }
  if (config.asic().irradiance_words() > 1) {  // two more words each, because rays and samples have three
    items.push_back({"Pipeline", "interpolators of irradiance", processors * kTrilinear * 2, kInterpolator});
    items.push_back({"Pipeline", "splats of green and blue", processors * 2, kSplit});
  }
  const Count links = processors > 1 ? 2 * processors : 0;
  items.push_back({"Control", "bits between parts",
                   (kFifosOfProcessor * processors + 2 * processors - 1) * kFifoPlaces * wire::kRayBits, kRegister});
  items.push_back({"Control", "bits at links", links * config.link().rays() * wire::kRayBits, kRegister});
  const Count tile_bits = 4 * static_cast<Count>(wire::voxel_bits(format, config.asic().irradiance_words()));
  items.push_back(
      {"Control", "bits on their way to memory", processors * config.cache().write_packets() * tile_bits, kRegister});
  return items;
}

std::string logic_text(const std::vector<LogicItem>& items) {
  std::string text;
  Count sum = 0, all = 0;
  const auto total = [&text](std::string_view name, Count transistors) {
    text += fmt::format("{:<41}{:>39.1f} M transistors\n", name, static_cast<double>(transistors) * 1e-6);
  };
  for (std::size_t i = 0; i < items.size(); ++i) {
    const LogicItem& item = items[i];
    text +=
        fmt::format("  {:<27}{:>8} x {:<7}{:>14} transistors\n", item.name, item.count, item.each, item.transistors());
    sum += item.transistors();
    all += item.transistors();
    if (i + 1 < items.size() && std::string_view(items[i + 1].part) == item.part) continue;
    total(item.part, sum);
    sum = 0;
  }
  total("All parts", all);
  return text;
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
  return text + "\nLogic; how it is counted: docs/guide/observation.md\n\n" + logic_text(cost.logic);
}

}  // namespace gicube::emu
