// What applications do with a board, call by call: the sessions that are kept of each released version
// (docs/contributing/release.md).
#pragma once

#include <gicube/board.h>

#include <span>
#include <string>

namespace gicube::captures {

// The board that they are recorded on. Small blocks: a small volume has several.
inline constexpr const char* kOptions = "?set=asic.block_voxels=8&set=asic.max_volume_voxels=64";

struct Session {
  const char* name;
  // All that the board returned, a line for each call.
  std::string (*use)(Board& board);
};

std::span<const Session> sessions();

}  // namespace gicube::captures
