// What every function of the C ABI is made of: it catches what is thrown, and remembers its words for the thread.
#pragma once

#include <concepts>
#include <cstdint>
#include <exception>
#include <new>
#include <string>

#include "gicube/c_api.h"
#include "gicube/error.h"

namespace gicube::c_api {

// A callback of the caller's asked for the end of the call.
class Stopped : public Error {
 public:
  using Error::Error;
};

// Keeps the error that is being handled for gicube_last_error(), and returns its status. Never throws.
gicube_status remember_current_error() noexcept;

template <std::invocable Work>
gicube_status call(const Work& work) noexcept {
  try {
    work();
    return GICUBE_OK;
  } catch (...) {
    return remember_current_error();
  }
}

// Checks of arguments; each throws BadArgument that names it.

template <typename T>
T& checked(const char* name, T* pointer) {
  if (pointer == nullptr) throw BadArgument(name, "a pointer", "NULL");
  return *pointer;
}

// `count` elements at `pointer`, which may be NULL only if there are none.
template <typename T>
T* checked(const char* name, T* pointer, std::size_t count) {
  constexpr std::size_t kMax = PTRDIFF_MAX / sizeof(T);
  if (count > kMax) throw BadArgument(name, "at most " + std::to_string(kMax) + " of them", std::to_string(count));
  if (pointer == nullptr && count > 0) throw BadArgument(name, "a pointer", "NULL");
  return pointer;
}

// The size of an array that the call fills or takes.
inline void check_count(const std::string& name, std::size_t got, std::size_t expected) {
  if (got != expected) throw BadArgument(name, std::to_string(expected), std::to_string(got));
}

template <typename Enum>
Enum choice(const std::string& name, std::int32_t value, Enum last) {
  if (value < 0 || value > static_cast<std::int32_t>(last)) {
    throw BadArgument(name, "0.." + std::to_string(static_cast<std::int32_t>(last)), std::to_string(value));
  }
  return static_cast<Enum>(value);
}

inline bool truth(const std::string& name, std::int32_t value) {
  if (value != 0 && value != 1) throw BadArgument(name, "0 or 1", std::to_string(value));
  return value == 1;
}

inline void check_reserved(const std::string& name, std::uint32_t value) {
  if (value != 0) throw BadArgument(name, "0", std::to_string(value));
}

}  // namespace gicube::c_api
