// A board that is large enough for small scans.
#pragma once

#include <cstdlib>
#include <string>

#include "gicube/board.h"

namespace gicube::samples {

inline Board open_board(const std::string& options = "") {
  return Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64" + options);
}

}  // namespace gicube::samples
