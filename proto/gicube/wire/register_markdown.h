// The register table and the memory map as Markdown, for docs/reference/protocol.md and `gicube-board --registers`.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include "gicube/wire/memory_map.h"
#include "gicube/wire/registers.h"

namespace gicube::wire {

inline constexpr std::array<const char*, 3> kAccessNames{"read", "read/write", "write"};  // indexed by Access

// Returns "0x" and at least `digits` upper-case hexadecimal digits.
inline std::string hex_text(std::uint64_t value, int digits) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "0x%0*llX", digits, static_cast<unsigned long long>(value));
  return text.data();
}

// One row per register, in the table's order, but the registers of the cut planes once, with i for the plane's number.
// Ends with a newline.
inline std::string register_markdown() {
  std::string out = "| offset | name | access | reset | meaning |\n|---|---|---|---|---|\n";
  for (const RegisterInfo& info : kRegisterTable) {
    const bool of_plane = info.offset >= reg::kCutPlane0 && info.offset < reg::kCutPlane0 + 16 * kMaxCutPlanes;
    if (of_plane && info.offset >= reg::kCutPlane0 + 16) continue;
    std::string name(info.name);
    if (of_plane) name.replace(name.find('0'), 1, "i");
    out += "| " + hex_text(info.offset, 3) + (of_plane ? " + 16 i" : "") + " | " + name + " | " +
           kAccessNames[static_cast<std::size_t>(info.access)] + " | " + hex_text(info.reset, 8) + " | " +
           std::string(info.meaning) + " |\n";
  }
  return out;
}

// One row per region, in the order of addresses; ends with a newline.
inline std::string memory_markdown() {
  std::string out = "| address | bytes | region | access | meaning |\n|---|---|---|---|---|\n";
  for (const MemoryRegion& region : kMemoryMap) {
    out += "| " + hex_text(region.base, 9) + " | " + std::to_string(region.bytes) + " | " + region.name + " | " +
           (region.writable ? "read/write" : "read") + " | " + region.meaning + " |\n";
  }
  return out;
}

}  // namespace gicube::wire
