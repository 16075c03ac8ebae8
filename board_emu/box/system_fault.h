// An error of the system, with what it is of.
#pragma once

#include <system_error>

namespace gicube::emu {

[[noreturn]] inline void fail(int error, const char* what) {
  throw std::system_error(error, std::generic_category(), what);
}

}  // namespace gicube::emu
