// Operations on one number, with the names that Highway has for vectors of them: a stage that is a template of its
// numbers is then one source for a ray alone and for rays in lanes (datapath/interval-inl.h, datapath/shading-inl.h).
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace gicube::emu {

template <class Number>
constexpr Number Min(Number a, std::type_identity_t<Number> b) {
  return b < a ? b : a;
}
template <class Number>
constexpr Number Max(Number a, std::type_identity_t<Number> b) {
  return a < b ? b : a;
}
constexpr std::int32_t Abs(std::int32_t x) { return x < 0 ? -x : x; }
constexpr double Abs(double x) { return x < 0 ? -x : x; }
constexpr double Trunc(double x) { return static_cast<double>(static_cast<std::int64_t>(x)); }
template <class Number>
constexpr Number IfThenElse(bool which, Number yes, std::type_identity_t<Number> no) {
  return which ? yes : no;
}
template <int kBits>
constexpr std::int32_t ShiftLeft(std::int32_t x) {
  return x << kBits;
}
template <int kBits>
constexpr std::int32_t ShiftRight(std::int32_t x) {
  return x >> kBits;
}

// `x` in all lanes of a number like the first.
template <class Number>
constexpr Number like(Number, std::type_identity_t<Number> x) {
  return x;
}
// Whether a mask is true in all lanes.
constexpr bool all(bool mask) { return mask; }
constexpr float to_float(std::int32_t x) { return static_cast<float>(x); }
// To the nearest whole number, ties to even.
inline std::int32_t nearest(float x) { return static_cast<std::int32_t>(std::lrintf(x)); }
// The entry of a table at a whole number.
inline double look_up(const double* table, double index) { return table[static_cast<std::size_t>(index)]; }

}  // namespace gicube::emu
