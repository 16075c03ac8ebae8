// The error of a wait that reached its deadline.
#pragma once

#include <fmt/format.h>

#include "gicube/error.h"
#include "gicube/time.h"

namespace gicube {

inline DeadlinePassed deadline_passed(Picoseconds deadline) {
  return DeadlinePassed(fmt::format("the result did not come by {} ps of simulated time", deadline));
}

}  // namespace gicube
