// Runs a function at the end of a scope.
#pragma once

namespace gicube::emu {

template <typename Function>
struct ScopeExit {
  Function function;
  ~ScopeExit() { function(); }
};

}  // namespace gicube::emu
