// Checks of arguments; each throws BadArgument that names the field, the expected and the given value.
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

// Throws BadArgument unless `good`. `got`: a text, an enumeration, or a number, which is written as by number_text().
template <typename Got>
void expect(bool good, const std::string& field, const std::string& expected, const Got& got) {
  if (good) return;
  if constexpr (std::is_enum_v<Got>) {
    throw BadArgument(field, expected, fmt::format("{}", static_cast<int>(got)));
  } else {
    throw BadArgument(field, expected, fmt::format("{}", got));
  }
}

// Throw BadArgument naming `field` unless the value is in low..high, both included, or is finite. NaN fails both.
void expect_within(const std::string& field, double value, double low, double high);
void expect_finite(const std::string& field, double value);
void expect_finite(const std::string& field, Vec3 value);  // names the component: "eye.x"

// Takes a function that returns the name, called only on failure: for checks of millions of values.
template <std::invocable Name>
void expect_within(const Name& name, double value, double low, double high) {
  if (!(value >= low && value <= high)) expect_within(std::string(name()), value, low, high);
}
template <std::invocable Name>
void expect_finite(const Name& name, double value) {
  if (!std::isfinite(value)) expect_finite(std::string(name()), value);
}

// `v` scaled to unit length, also if squares of its components over- or underflow. The zero vector is returned
// unchanged.
Vec3 unit(Vec3 v);

}  // namespace gicube
