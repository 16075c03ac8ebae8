// Callers of the management plane that a board must survive.
#pragma once

#include <cstdint>
#include <string>

namespace gicube::system_test {

inline constexpr int kHostileCalls = 9;

// Goes to the management plane at 127.0.0.1:`port` once and does something wrong in the `way`-th manner
// (0..kHostileCalls - 1). `reader`: a token with the right to read. Returns how often it was let do what it must not:
// 0.
int misbehave_at_management(std::uint16_t port, const std::string& reader, int way, std::uint64_t seed);

}  // namespace gicube::system_test
