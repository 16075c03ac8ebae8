// Operations on one number, with the names that Highway has for vectors of them: a stage that is a template of its numbers is
// then one source for a ray alone and for rays in lanes (datapath/interval-inl.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace gicube::emu {

constexpr double Min(double a, double b) { return b < a ? b : a; }
constexpr double Max(double a, double b) { return a < b ? b : a; }
constexpr double Abs(double x) { return x < 0 ? -x : x; }
constexpr double Trunc(double x) { return static_cast<double>(static_cast<std::int64_t>(x)); }
constexpr double IfThenElse(bool which, double yes, double no) { return which ? yes : no; }

// `x` in all lanes of a number like the first.
constexpr double like(double, double x) { return x; }
// Whether a mask is true in all lanes.
constexpr bool all(bool mask) { return mask; }
// The entry of a table at a whole number.
inline double look_up(const double* table, double index) { return table[static_cast<std::size_t>(index)]; }

}  // namespace gicube::emu
