// What a check says when it refuses.
#pragma once

#include <string>

#include "gicube/error.h"

namespace gicube {

// The message of the BadArgument that `call` throws; "accepted" if it throws nothing.
template <typename Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const BadArgument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace gicube
