// The checks that every argument goes through, and the words in which a refusal names it.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <concepts>
#include <string>
#include <type_traits>

#include "gicube/error.h"
#include "gicube/vector.h"

namespace gicube {

// The shortest text that reads back as the same number; "nan" and "inf" by name.
std::string number_text(double value);

// Throws BadArgument unless `good`. `got`: a text, a number, which is shown as by number_text(), or an enumeration.
template <typename Got>
void expect(bool good, const std::string& field, const std::string& expected, const Got& got) {
  if (good) return;
  if constexpr (std::is_enum_v<Got>) {
    throw BadArgument(field, expected, fmt::format("{}", static_cast<int>(got)));
  } else {
    throw BadArgument(field, expected, fmt::format("{}", got));
  }
}

// Throw BadArgument naming `field`: value in low..high (both included), value finite. NaN passes none of them.
void expect_within(const std::string& field, double value, double low, double high);
void expect_finite(const std::string& field, double value);
void expect_finite(const std::string& field, Vec3 value);  // names the component: "eye.x"

// Takes a name that name() makes only when it is needed: for checks of millions of values.
template <std::invocable Name>
void expect_within(const Name& name, double value, double low, double high) {
  if (!(value >= low && value <= high)) expect_within(std::string(name()), value, low, high);
}
template <std::invocable Name>
void expect_finite(const Name& name, double value) {
  if (!std::isfinite(value)) expect_finite(std::string(name()), value);
}

// `v` scaled to unit length, also where squares of its components over- or underflow; the zero vector as it is.
Vec3 unit(Vec3 v);

}  // namespace gicube
