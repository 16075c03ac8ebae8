// Cases of the suite: a rule of docs/reference/protocol.md, and a function that tests whether a board follows it.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace gicube::conformance {

class Host;
class Place;

// A board may claim a class if all cases of it and of class 0 pass.
inline constexpr const char* kClassNames[] = {"opens and renders", "rays", "light", "time", "pictures",
                                              "lasting sessions"};
inline constexpr unsigned kClasses = std::size(kClassNames);

struct Case {
  unsigned level;    // its class
  const char* name;  // group.what, for --filter
  const char* rule;  // P301
  // In a session that has just been opened, or with connections that the case makes itself.
  std::variant<void (*)(Host& host), void (*)(Place& place)> run;
};

// All cases, class by class within each group.
std::vector<Case> all_cases();

// Groups, one a source of cases/.
std::span<const Case> handshake_cases();
std::span<const Case> frame_cases();
std::span<const Case> credit_cases();
std::span<const Case> register_cases();
std::span<const Case> memory_cases();
std::span<const Case> command_cases();
std::span<const Case> sample_cases();
std::span<const Case> picture_cases();
std::span<const Case> ray_cases();
std::span<const Case> deposit_cases();
std::span<const Case> light_cases();
std::span<const Case> time_cases();
std::span<const Case> session_cases();

// The board broke the rule. The text says what was expected and what came.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <typename... Args>
void check(bool holds, fmt::format_string<Args...> expectation, Args&&... args) {
  if (!holds) throw Failure(fmt::format(expectation, std::forward<Args>(args)...));
}
template <typename T>
void check_same(const char* what, T got, std::type_identity_t<T> expected) {
  if constexpr (std::is_enum_v<T>) {
    check_same(what, fmt::underlying(got), fmt::underlying(expected));
  } else {
    check(got == expected, "{}: expected {}, got {}", what, expected, got);
  }
}
inline void check_near(const char* what, double got, double expected, double tolerance) {
  check(std::abs(got - expected) <= tolerance, "{}: expected {} within {}, got {}", what, expected, tolerance, got);
}

}  // namespace gicube::conformance
