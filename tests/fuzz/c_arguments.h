// Arguments for the C ABI, made of a fuzzer's input.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "gicube/c_api.h"
#include "input.h"

namespace gicube::fuzz {

inline void check(gicube_status status) {
  expect(std::strcmp(gicube_status_name(status), "?") != 0, "a status has a name");
  expect(status != GICUBE_INTERNAL, "no input is the driver's fault");
  expect(status != GICUBE_DEVICE_LOST && status != GICUBE_TIMED_OUT, "no input loses the board");
  if (status == GICUBE_OK) return;
  expect(*gicube_last_error() != 0, "a failure has words");
  if (status == GICUBE_BAD_ARGUMENT) expect(*gicube_last_error_field() != 0, "a bad argument has a name");
}

// A record in exactly the memory that it says it has, so that the address sanitizer sees who goes beyond. Its fields
// are the defaults, but for some bytes from the input; pointers are not touched.
template <typename Record>
class Argument {
 public:
  using Init = gicube_status (*)(Record*, std::size_t);

  Argument(Input& input, Init init) {
    Record record{};
    check(init(&record, sizeof record));
    std::uint32_t size = sizeof record;
    const std::uint8_t kind = input.u8();
    if (kind == 255) size = input.u32();
    if (kind == 254) size = sizeof record + input.u8();
    if (kind == 253) size = input.u8();
    is_null_ = kind == 252;
    bytes_.resize(std::clamp<std::size_t>(size, sizeof size, 70'000));
    std::memcpy(bytes_.data(), &record, std::min(bytes_.size(), sizeof record));
    std::memcpy(bytes_.data(), &size, sizeof size);
    if (bytes_.size() > sizeof record && input.u8() == 255) bytes_.back() = 1;
  }

  // The record, if all of it is there.
  Record* whole() { return bytes_.size() >= sizeof(Record) ? reinterpret_cast<Record*>(bytes_.data()) : nullptr; }
  Record* get() { return is_null_ ? nullptr : reinterpret_cast<Record*>(bytes_.data()); }

 private:
  std::vector<std::uint8_t> bytes_;
  bool is_null_ = false;
};

inline std::int32_t whole_number(Input& input, std::uint32_t usual) {
  const std::uint8_t kind = input.u8();
  return kind == 255 ? input.take<std::int32_t>() : kind == 254 ? -1 : static_cast<std::int32_t>(kind % usual);
}

template <std::size_t n>
void put(Input& input, double (&numbers)[n]) {
  for (double& number : numbers) number = input.number();
}

inline gicube_host_ray ray(Input& input) {
  gicube_host_ray ray{};
  ray.id = input.u8();
  put(input, ray.position);
  put(input, ray.direction);
  ray.length = input.number();
  ray.energy = input.number();
  return ray;
}

inline gicube_box box(Input& input) {
  gicube_box box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = whole_number(input, 8);
    box.size[axis] = whole_number(input, 9);
  }
  return box;
}

}  // namespace gicube::fuzz
