// A limit of this process and its current use, for monitoring (docs/reference/security.md, limits).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace gicube::emu {

struct Quota {
  const char* name = "";                 // with its unit, like a metric's name
  std::optional<std::uint32_t> board{};  // none: for the whole process
  std::uint64_t used = 0;
  std::uint64_t limit = 0;
};

// Returns the current values. Thread-safe.
using Quotas = std::function<std::vector<Quota>()>;

}  // namespace gicube::emu
