// Errors of commands.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "datapath/advance.h"
#include "gicube/wire/frame.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/record.h"
#include "words/words.h"

namespace gicube::emu {

// Thrown to end a command without a result.
struct CommandFault {
  wire::ErrorCode error = wire::ErrorCode::kBadValue;
  std::string text;  // text of the error completion
};

[[noreturn]] inline void refuse(const std::string& text) { throw CommandFault{.text = text}; }
[[noreturn]] inline void refuse(const std::string& field, const std::string& range, std::uint64_t got) {
  refuse(field + ": expected " + range + ", got " + std::to_string(got));
}
inline void expect(bool good, const char* field, const char* range, std::uint64_t got) {
  if (!good) [[unlikely]]
    refuse(field, range, got);
}

// The record with which a payload begins.
template <typename Header>
Header header_of(std::span<const std::uint8_t> payload) {
  constexpr std::size_t kBytes = wire::bytes_of<Header>();
  if (payload.size() < kBytes) refuse("payload", "at least " + std::to_string(kBytes) + " bytes", payload.size());
  return wire::decode<Header>(payload);
}

// Checks one of a command's parts and prefixes its errors with the number: "ray 7: ...".
template <typename Check>
void check_part(const char* what, std::size_t number, const Check& check) {
  try {
    check();
  } catch (CommandFault& fault) {
    fault.text = std::string(what) + " " + std::to_string(number) + ": " + fault.text;
    throw;
  }
}

// Checks a ray that the host sent.
inline void check_ray(const wire::Ray& ray, const Point& extent) {
  const Point position{static_cast<std::int32_t>(ray.position[0]), static_cast<std::int32_t>(ray.position[1]),
                       static_cast<std::int32_t>(ray.position[2])};
  if (!inside(position, extent)) refuse("position: expected a point of the volume");
  const Point d{ray.direction[0], ray.direction[1], ray.direction[2]};
  const double length = std::sqrt(static_cast<double>(dot(d, d))) / (1 << wire::kDirectionFractionBits);
  // The step of a shorter direction could round to zero.
  if (!(std::abs(length - 1) < 0.01)) refuse("direction: expected a unit vector to within 1%");
}

}  // namespace gicube::emu
