// Runs a function at the end of a scope.
#pragma once

namespace gicube::emu {

template <typename Function>
struct Finally {
  Function function;
  ~Finally() { function(); }
};
template <typename Function>
Finally(Function) -> Finally<Function>;  // clang 14 does not deduce it

}  // namespace gicube::emu
