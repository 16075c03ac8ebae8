// A board that is large enough for small scans.
#pragma once

#include <cstdlib>
#include <string>

#include "gicube/board.h"

namespace gicube::samples {

inline Board open_board(const std::string& options = "") {
  ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  return Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64" + options);
}

}  // namespace gicube::samples
