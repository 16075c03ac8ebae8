// A limit of this process and how much of it is taken: for who watches it (docs/reference/security.md, limits).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace gicube::emu {

struct Quota {
  const char* name = "";                 // with its unit, as a metric's
  std::optional<std::uint32_t> board{};  // none: of the whole process
  std::uint64_t used = 0;
  std::uint64_t limit = 0;
};

// What they are now; any thread.
using Quotas = std::function<std::vector<Quota>()>;

}  // namespace gicube::emu
