// PCI configuration space and registers.
#include <algorithm>

#include "gicube/wire/pci_config.h"
#include "tools/conformance/host.h"

namespace gicube::conformance {
namespace {

namespace pci = wire::pci;

std::uint32_t agp_rates(Host& host) {
  const bool is_agp = (host.read_config(pci::kPowerManagement) >> 8 & 0xFF) == pci::kAgp;
  return is_agp ? host.read_config(pci::kAgp + 4) & 7 : 0;
}

// Whether the host may write and read the register.
bool is_plain(const wire::RegisterInfo& info) { return info.access == wire::Access::kReadWrite; }

// A value that the register takes, other than its reset value.
std::uint32_t other_value(const wire::RegisterInfo& info) {
  switch (info.offset) {
    case reg::kVolumeX:
    case reg::kVolumeY:
    case reg::kVolumeZ: return 5;
    case reg::kBricks: return 1;
    case reg::kCutPlanes: return 6;
    default: return info.reset == 0 ? 0x4321 : info.reset / 2;
  }
}

void write_other_values(Host& host) {
  for (const wire::RegisterInfo& info : wire::kRegisterTable) {
    if (is_plain(info)) host.write_register(info.offset, other_value(info));
  }
}

struct Range {
  std::uint32_t offset, least, most;  // most: 0 if it depends on the board
};
constexpr Range kRanges[] = {{reg::kVolumeX, 2, 0},
                             {reg::kVolumeY, 2, 0},
                             {reg::kVolumeZ, 2, 0},
                             {reg::kSpacingX, 1024, 64 << 16},
                             {reg::kSpacingY, 1024, 64 << 16},
                             {reg::kSpacingZ, 1024, 64 << 16},
                             {reg::kStep, 1024, 16 << 16},
                             {reg::kOpacityThreshold, 0, (1 << 24) - 1},
                             {reg::kPipeline, 0, 127},
                             {reg::kLifetime, 0, 1023},
                             {reg::kCutPlanes, 0, 6},
                             {reg::kBricks, 0, 1}};

void expect_status(Host& host, std::uint32_t bits, std::uint32_t address) {
  check_same("STATUS", host.read_register(reg::kStatus), bits);
  check_same("ERROR_ADDRESS", host.read_register(reg::kErrorAddress), address);
  host.write_register(reg::kStatusClear, ~0u);
}

constexpr Case kCases[] = {
    {0, "config.reset", "P1001",
     [](Host& host) {
       const wire::PciConfigSpace expected = wire::pci_config_at_reset(agp_rates(host));
       for (std::uint32_t at = 0; at < wire::kPciConfigBytes; at += 4) {
         const std::uint32_t got = host.read_config(at);
         check(got == expected[at / 4], "dword 0x{:02x}: expected 0x{:08x}, got 0x{:08x}", at, expected[at / 4], got);
       }
     }},
    {0, "config.bars", "P1002",
     [](Host& host) {
       const std::pair<std::uint32_t, std::uint32_t> masks[] = {
           {pci::kBar0Register, 0xFFFF'F000}, {pci::kBar2Low, 0xC}, {pci::kBar2High, 0xFFFF'FFF0}};
       for (const auto& [offset, mask] : masks) {
         host.request(FrameType::kConfigWrite, words({offset, ~0u}));
         check_same("a BAR's size mask", host.read_config(offset), mask);
       }
     }},
    {0, "config.writes", "P1002",
     [](Host& host) {
       const wire::PciConfigSpace reset = wire::pci_config_at_reset(agp_rates(host));
       const std::pair<std::uint32_t, std::uint32_t> changed[] = {{pci::kCommandStatus, 0x0010'0007u},
                                                                  {pci::kInterrupt, 0x01FFu}};
       for (const std::uint32_t offset : {pci::kIds, pci::kCommandStatus, pci::kClassRevision, 0x14u, pci::kSubsystem,
                                          pci::kCapabilities, pci::kInterrupt, pci::kPowerManagement, 0x80u, 0xFCu}) {
         host.request(FrameType::kConfigWrite, words({offset, ~0u}));
         std::uint32_t expected = reset[offset / 4];
         for (const auto& [at, value] : changed) expected = at == offset ? value : expected;
         check(host.read_config(offset) == expected, "dword 0x{:02x}: expected 0x{:08x}", offset, expected);
       }
     }},
    {0, "config.beyond", "P1003",
     [](Host& host) {
       for (const std::uint32_t offset : {256u, 2u, 0x8000'0000u}) {
         const std::string what = fmt::format("configuration at offset 0x{:02x}", offset);
         check_same(what.c_str(), host.read_config(offset), ~0u);
       }
     }},
    {0, "register.reset", "P1101",
     [](Host& host) {
       for (const wire::RegisterInfo& info : wire::kRegisterTable) {
         const bool fixed = info.access == wire::Access::kReadOnly && info.offset != reg::kId &&
                            info.offset != reg::kStatus && info.offset != reg::kErrorAddress;
         if (fixed || info.access == wire::Access::kWriteOnly) continue;
         const std::uint32_t got = host.read_register(info.offset);
         check(got == info.reset, "{}: expected 0x{:08x} at reset, got 0x{:08x}", info.name, info.reset, got);
       }
     }},
    {0, "register.configuration", "P1106",
     [](Host& host) {
       const auto one_of = [&host](const char* name, std::uint32_t offset,
                                   std::initializer_list<std::uint32_t> values) {
         const std::uint32_t got = host.read_register(offset);
         check(std::ranges::find(values, got) != values.end(), "{}: expected a named value, got {}", name, got);
       };
       one_of("DATAPATH", reg::kDatapath, {1, 2});
       one_of("FIDELITY", reg::kFidelity, {1, 2, 3});
       one_of("BLOCK_VOXELS", reg::kBlockVoxels, {8, 16, 32, 64});
       one_of("VOXEL_FORMAT", reg::kVoxelFormat, {1, 2, 3});
       one_of("IRRADIANCE_WORDS", reg::kIrradianceWords, {1, 3});
       const std::uint32_t edge = host.read_register(reg::kMaxVolumeVoxels);
       check(edge >= host.read_register(reg::kBlockVoxels) && edge <= wire::kMaxVolumeEdge,
             "MAX_VOLUME_VOXELS: expected BLOCK_VOXELS to 1024, got {}", edge);
       for (const std::uint32_t offset : {reg::kProcessors, reg::kQueueRays, reg::kCoreKhz, reg::kMaxMemory}) {
         check(host.read_register(offset) != 0, "register 0x{:03x}: expected a value, got 0", offset);
       }
     }},
    {0, "register.unmapped", "P1101",
     [](Host& host) {
       for (const std::uint32_t offset :
            {reg::kStatusClear, reg::kControl, reg::kDropBlock, 0x05Cu, 0x0F0u, 0xFFCu, 0x1000u, 0x002u}) {
         check(host.read_register(offset) == ~0u, "register 0x{:03x}: expected all ones", offset);
       }
       check_same("STATUS", host.read_register(reg::kStatus), 0);
     }},
    {0, "register.holds", "P1107",
     [](Host& host) {
       write_other_values(host);
       for (const wire::RegisterInfo& info : wire::kRegisterTable) {
         if (!is_plain(info)) continue;
         const std::uint32_t got = host.read_register(info.offset);
         check(got == other_value(info), "{}: expected {}, got {}", info.name, other_value(info), got);
       }
       check_same("STATUS", host.read_register(reg::kStatus), 0);
     }},
    {0, "register.read_only", "P1102",
     [](Host& host) {
       for (const std::uint32_t offset : {reg::kId, reg::kFidelity, reg::kBlockVoxels, reg::kStatus, 0x05Cu, 0xFFCu}) {
         const std::uint32_t before = host.read_register(offset);
         host.write_register(offset, before ^ 1);
         expect_status(host, wire::kStatusBadAddress, offset);
         check(host.read_register(offset) == before, "register 0x{:03x}: expected it unchanged", offset);
       }
     }},
    {0, "register.ranges", "P1105",
     [](Host& host) {
       for (const Range& range : kRanges) {
         host.write_register(range.offset, range.least);
         check(host.read_register(range.offset) == range.least, "register 0x{:03x}: expected to take {}", range.offset,
               range.least);
         std::vector<std::uint32_t> wrong{range.most == 0 ? wire::kMaxVolumeEdge + 1 : range.most + 1, ~0u};
         if (range.least > 0) wrong.insert(wrong.end(), {range.least - 1, 0});
         for (const std::uint32_t value : wrong) {
           host.write_register(range.offset, value);
           expect_status(host, wire::kStatusBadValue, range.offset);
           check(host.read_register(range.offset) == range.least, "register 0x{:03x}: expected it as before {}",
                 range.offset, value);
         }
         if (range.most == 0) continue;
         host.write_register(range.offset, range.most);
         check(host.read_register(range.offset) == range.most, "register 0x{:03x}: expected to take {}", range.offset,
               range.most);
       }
     }},
    {0, "register.sticky", "P1108",
     [](Host& host) {
       host.write_register(reg::kStep, 0);
       host.write_register(reg::kStep, wire::kStepOne);
       check_same("STATUS after a good write", host.read_register(reg::kStatus), wire::kStatusBadValue);
       host.write_register(reg::kId, 0);
       check_same("STATUS", host.read_register(reg::kStatus), wire::kStatusBadValue | wire::kStatusBadAddress);
       host.write_register(reg::kStatusClear, wire::kStatusBadAddress);
       check_same("STATUS after one bit was cleared", host.read_register(reg::kStatus), wire::kStatusBadValue);
       host.write_register(reg::kStatusClear, wire::kStatusBadValue);
       check_same("STATUS after both were", host.read_register(reg::kStatus), 0);
     }},
    {0, "register.control_reset", "P1109",
     [](Host& host) {
       write_other_values(host);
       host.write_register(reg::kId, 0);
       host.write_register(reg::kControl, wire::kControlReset);
       for (const wire::RegisterInfo& info : wire::kRegisterTable) {
         if (!is_plain(info) && info.offset != reg::kStatus) continue;
         const std::uint32_t got = host.read_register(info.offset);
         check(got == info.reset, "{}: expected 0x{:08x} after a reset, got 0x{:08x}", info.name, info.reset, got);
       }
     }},
};

}  // namespace

std::span<const Case> register_cases() { return kCases; }

}  // namespace gicube::conformance
