// Damage to a file's bytes.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace gicube::scene {

// One to four bytes changed, removed or doubled; new ones are often one of `likely`, those that matter most in such a
// file.
inline std::string damaged(std::string bytes, std::string_view likely, std::mt19937& random) {
  for (std::uint32_t changes = 1 + random() % 4; changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 4) {
      case 0: bytes[at] = static_cast<char>(random()); break;
      case 1: bytes[at] = likely[random() % likely.size()]; break;
      case 2: bytes.erase(at, 1 + random() % 8); break;
      default: bytes.insert(at, bytes.substr(at, 1 + random() % 8)); break;
    }
  }
  return bytes;
}

}  // namespace gicube::scene
