// Where a file came from, written into it. PNG has it as text, EXR as attributes, NRRD as key/value pairs, NIfTI as an
// extension of comments; `gicube-smi show FILE` prints it. The same inputs give the same bytes: there is no time, no
// host and no folder in it but what the command line names.
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
  std::string command{};      // the command line as it was given: command_line()
  std::string config_hash{};  // of the board's configuration (BoardInfo::config_hash), as hex()
  std::string fidelity{};     // of the board: functional or cycle
  std::string scene_hash{};   // of what was computed with: scene_hash(), or of a scan's projections, as hex()
};

// The entries in the files: "gicube.program" and so on with their values.
GICUBE_API std::vector<std::pair<std::string, std::string>> entries(const Provenance& provenance);

// The program's name without its folder, and the arguments; quoted where a POSIX shell needs it. An argument that is no
// UTF-8, as a file's name may be, is written as bash does: $'gr\xfc'.
GICUBE_API std::string command_line(int argc, const char* const* argv);

// A hash of these bytes after others, whose hash is `before`. For identity only: anyone could make other bytes with the
// same.
GICUBE_API std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t before = 0);

// 16 hexadecimal digits.
GICUBE_API std::string hex(std::uint64_t hash);

}  // namespace gicube::scene
