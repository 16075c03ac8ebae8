// Clients that a board must survive: broken ones and hostile ones, drawn by a seed.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "raw_client.h"

namespace gicube::system_test {

inline constexpr int kHostileWays = 12;

// Where a board is reached, and with which token, if any.
struct Door {
  std::function<reference::RawClient()> connect;
  std::string token{};
};

// Connects once and does something wrong in the `way`-th manner (0..kHostileWays - 1), with what is random drawn by
// `seed`; returns when the board has ended the connection or it has itself. False if nobody took the connection.
bool misbehave(const Door& door, int way, std::uint64_t seed);

}  // namespace gicube::system_test
