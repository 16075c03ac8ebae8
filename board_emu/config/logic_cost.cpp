#include "logic_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string_view>

#include "asic/fifo_places.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

namespace {

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
  const v1::AsicConfig& asic = config.asic();
  const Count across = std::max(1u, asic.max_volume_voxels() / asic.block_voxels());
  const bool single = config.sorter().queues() == v1::single;
  const Count queues = single ? asic.processors() : across * across * across;
  const Count pointer = std::bit_width(asic.queue_rays() - 1u), number = std::bit_width(queues - 1);
  const Count item = number + pointer + 1;  // a queue and its importance
  // Two buffers per rank. Each selects its own item, the other's, or the neighbour's above or below.
  if (!single)
    items.push_back({"Queues", "ranks of the sorters", queues, item * (2 * kRegister + kAdder + 4 * kMultiplexer)});
  // Read and write positions, and the number of rays.
  items.push_back({"Queues", "pointers", queues, (3 * pointer + 1) * (kRegister + kAdder)});
}

void add_cache(std::vector<LogicItem>& items, const v1::BoardConfig& config) {
  const Count processors = config.asic().processors(), edge = config.asic().block_voxels() / 2 + 1;
  const Count across = std::max(1u, config.asic().max_volume_voxels() / config.asic().block_voxels());
  const Count tag = std::bit_width(across * across * across - 1) + 1;  // a block, or none
  items.push_back(
      {"Volume cache", "bits of tags", processors * edge * edge * (config.asic().block_voxels() + 1) * tag, kSram});
  items.push_back(
      {"Volume cache", "comparators of eight voxels", processors * 8 * config.cache().ways(), tag * kAdder});
}

}  // namespace

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

std::string to_string(const std::vector<LogicItem>& items) {
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

}  // namespace gicube::emu
