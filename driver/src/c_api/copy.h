// Copies values between records of C and of C++. fields.h lists the fields once for both directions.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "encode/argument.h"
#include "gicube/c_types.h"
#include "gicube/illumination.h"
#include "gicube/vector.h"

namespace gicube::c_api {

template <typename Enum>
Enum choice(const std::string& name, std::int32_t value, Enum last) {
  const auto max = static_cast<std::int32_t>(last);
  expect(value >= 0 && value <= max, name, fmt::format("0..{}", max), value);
  return static_cast<Enum>(value);
}

inline bool truth(const std::string& name, std::int32_t value) {
  expect(value == 0 || value == 1, name, "0 or 1", value);
  return value == 1;
}

inline Vec3 to_vec3(const double (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

// Copies fields to a record of C, or from it. Then they are checked: BadArgument names the field.
template <bool kToRecord>
struct Copy {
  std::string record;  // its name in error messages

  template <typename C, typename T>
  void number(C& c, T& value) const {
    if constexpr (kToRecord) {
      c = static_cast<C>(value);
    } else {
      value = static_cast<T>(c);
    }
  }
  template <typename C, std::size_t kCount>
  void numbers(C (&c)[kCount], auto& values) const {
    for (std::size_t i = 0; i < kCount; ++i) number(c[i], values[i]);
  }
  void truth(const char* field, std::int32_t& c, bool& value) const {
    if (kToRecord) {
      c = value;
    } else {
      value = c_api::truth(name(field), c);
    }
  }
  template <typename Enum>
  void choice(const char* field, std::int32_t& c, Enum& value, Enum last) const {
    if (kToRecord) {
      c = static_cast<std::int32_t>(value);
    } else {
      value = c_api::choice(name(field), c, last);
    }
  }
  void vector(double (&c)[3], Vec3& value) const {
    if (kToRecord) {
      c[0] = value.x;
      c[1] = value.y;
      c[2] = value.z;
    } else {
      value = to_vec3(c);
    }
  }
  void milliseconds(std::uint64_t& c, std::chrono::milliseconds& value) const {
    constexpr std::uint64_t kLongest = 1000ull * 60 * 60 * 24 * 365;  // chosen: a year, which fits the clock
    if (kToRecord) {
      c = static_cast<std::uint64_t>(value.count());
    } else {
      value = std::chrono::milliseconds(std::min(c, kLongest));
    }
  }
  void reserved(const char* field, auto& c) const {
    if (!kToRecord) expect(c == 0, name(field), "0", c);
  }

 private:
  std::string name(const char* field) const { return record + "." + field; }
};

// A record of C that stands for `value`.
template <typename Record, typename T>
Record to_record(T value) {
  Record record{};
  copy_fields(Copy<true>{}, record, value);
  return record;
}

// The value for which an item of an array stands; `name` is the item's. Throws BadArgument.
template <typename T, typename Record>
T from_record(const std::string& name, Record record) {
  T value{};
  copy_fields(Copy<false>{name}, record, value);
  return value;
}
template <>
Light from_record<Light>(const std::string& name, gicube_light light);

}  // namespace gicube::c_api
