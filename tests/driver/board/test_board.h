// A small volume, its rays and its board, for the tests of the public interface.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gicube/board.h"

namespace gicube {

// Small volumes then have several blocks.
constexpr const char* kSmallBlocks = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64";

// A board of kSmallBlocks and the id of its process, which may be stopped or killed.
struct BoardProcess {
  Board board;
  pid_t id;
};
BoardProcess open_board_process(const OpenOptions& options = {});
// Returns a board with load_box() whose process does nothing until it gets SIGCONT or SIGKILL.
BoardProcess stopped_board(const OpenOptions& options = {});

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

// Loads BoxVolume(32, 8, 23), and sets step_function(opacity).
void load_box(Board& board, double opacity = 0.1);
Board box_board(double opacity = 0.1, const OpenOptions& options = {});

// Along +z onto the middle of a volume of `size`^3.
View front_view(int size);

// Along +z from the face z = 0 of a volume of 32^3; ids 0, 1, ...
std::vector<HostRay> front_rays(std::uint32_t count);

}  // namespace gicube
