#include "asic/memory_standards.h"

#include <algorithm>

#include "asic/ddr/standard.h"
#include "asic/rdram/standard.h"

namespace gicube::emu {

namespace {

struct Row {
  v1::MemoryStandard memory;
  dram::Standard (*standard)(const v1::BoardConfig& config);
  std::unique_ptr<dram::Memory> (*make)(const v1::BoardConfig& config, std::uint32_t blocks);
  std::uint32_t (*devices_needed)(const v1::BoardConfig& config, std::uint32_t blocks);
};

constexpr Row kRows[] = {{v1::rdram, rdram::standard, rdram::make_memory, rdram::devices_needed},
                         {v1::ddr, ddr::standard, ddr::make_memory, ddr::devices_needed}};

// The configuration has been checked; what is not there has the first's numbers.
const Row& row(const v1::BoardConfig& config) {
  const auto* found =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& each) { return each.memory == config.memory(); });
  return found == std::end(kRows) ? kRows[0] : *found;
}

}  // namespace

dram::Standard memory_standard(const v1::BoardConfig& config) { return row(config).standard(config); }

std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks) {
  return row(config).make(config, std::max(1u, blocks));
}

std::uint32_t memory_devices_needed(const v1::BoardConfig& config, std::uint32_t blocks) {
  return row(config).devices_needed(config, blocks);
}

}  // namespace gicube::emu
