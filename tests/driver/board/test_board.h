// A private board and a small volume for the tests of the public interface.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <vector>

#include "gicube/board.h"

namespace gicube::reference {

// Small volumes then have several blocks.
constexpr const char* kSmallBlocks = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64";

// Opens `uri` with the gicube-board of this build tree.
Board open_board(const std::string& uri = "emu:", const OpenOptions& options = {});

// A board like open_board(kSmallBlocks)'s with the id of its process, which may be stopped or killed.
struct BoardProcess {
  Board board;
  pid_t id;
};
BoardProcess open_board_process(const OpenOptions& options = {});

// A cube of `size`^3 bytes, 0 but for a box of 200 in the voxels low..high, both included, on each axis.
struct BoxVolume {
  int size = 32;
  int low = 8;
  int high = 23;
  std::vector<std::byte> samples;

  BoxVolume(int edge, int first, int last);
  VolumeView view() const;
};

// Invisible below 100, opacity `opacity` a voxel above.
TransferFunction step_function(double opacity);

// Along +z onto the middle of a volume of `size`^3.
View front_view(int size);

}  // namespace gicube::reference
