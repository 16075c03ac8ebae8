// The origin of a file, written into it: as text in PNG, attributes in EXR, key/value pairs in NRRD, and an extension
// of comments in NIfTI; `gicube-smi show FILE` prints it. The same inputs give the same bytes, because it contains no
// time, no host, and no folder except those on the command line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gicube/export.h"

namespace gicube::scene {

// Empty entries are omitted.
struct Provenance {
  std::string program{}, version{};
  std::string command{};      // the command line: command_line()
  std::string config_hash{};  // of the board's configuration (BoardInfo::config_hash), as hex()
  std::string fidelity{};     // of the board: functional or cycle
  std::string scene_hash{};   // of the input: scene_hash(), or of a scan's projections, as hex()
};

// The entries in the files: "gicube.program" and so on with their values.
GICUBE_API std::vector<std::pair<std::string, std::string>> entries(const Provenance& provenance);

// The program's name without its folder, and the arguments, quoted where a POSIX shell needs it. An argument that is
// not UTF-8, such as a file's name, is written like bash does: $'gr\xfc'.
GICUBE_API std::string command_line(int argc, const char* const* argv);

// A hash of these bytes after others, whose hash is `before`. It is not cryptographic: other bytes with the same hash
// can be constructed.
GICUBE_API std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t before = 0);

// 16 hexadecimal digits.
GICUBE_API std::string hex(std::uint64_t hash);

}  // namespace gicube::scene
