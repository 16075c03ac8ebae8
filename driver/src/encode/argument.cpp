#include "encode/argument.h"

#include <algorithm>

namespace gicube {

std::string number_text(double value) { return fmt::format("{}", value); }

void expect_within(const std::string& field, double value, double low, double high) {
  if (!(value >= low && value <= high)) throw BadArgument(field, fmt::format("{}..{}", low, high), number_text(value));
}

void expect_finite(const std::string& field, double value) {
  if (!std::isfinite(value)) throw BadArgument(field, "a finite number", number_text(value));
}

void expect_finite(const std::string& field, Vec3 value) {
  expect_finite(field + ".x", value.x);
  expect_finite(field + ".y", value.y);
  expect_finite(field + ".z", value.z);
}

Vec3 unit(Vec3 v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (largest == 0) return v;
  return normalise({v.x / largest, v.y / largest, v.z / largest});
}

}  // namespace gicube
