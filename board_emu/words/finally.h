// Runs a function at the end of a scope.
#pragma once

namespace gicube::emu {

template <typename Function>
struct Finally {
  Function function;
  ~Finally() { function(); }
};

}  // namespace gicube::emu
