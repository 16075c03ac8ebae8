// What stands behind a gicube_board.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "call.h"
#include "gicube/board.h"

struct GICUBE_HIDDEN gicube_board {
  explicit gicube_board(gicube::Board opened) : board(std::move(opened)) {}

  gicube::Board board;
  std::mutex mutex;                                   // of what follows; never held while the board works
  std::map<std::uint32_t, gicube::RayBatch> arrived;  // polled, and not received yet
  std::vector<std::uint32_t> announce;  // of those, in their order, the ones to tell gicube_poll()'s caller
  std::set<std::uint32_t> deposits;     // under way: no rays of theirs come back
  std::vector<std::string> warnings;    // of the last illumination
  std::pair<int, int> framebuffer{};    // width and height
};

namespace gicube::c_api {

inline gicube_board& checked_board(gicube_board* board) {
  if (board == nullptr) throw BadArgument("board", "an open board", "NULL");
  return *board;
}

// The caller's progress callback as the driver's; empty if it is NULL.
Progress to_progress(gicube_progress progress, void* user);

inline Vec3 to_vec3(const double (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

inline void put(Vec3 from, double (&xyz)[3]) {
  xyz[0] = from.x;
  xyz[1] = from.y;
  xyz[2] = from.z;
}

// Calls that move one value a voxel of a box.
gicube_status read_box(gicube_board* board, const gicube_box* box, float* values, std::size_t count,
                       std::vector<float> (Board::*read)(const VoxelBox&));
gicube_status write_box(gicube_board* board, const gicube_box* box, const float* values, std::size_t count,
                        void (Board::*write)(const VoxelBox&, std::span<const float>));

gicube_lighting_report to_c(const LightingReport& report);

gicube_volume default_volume();

}  // namespace gicube::c_api
