// Radiosity in closed rooms, where all light is accounted for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "form_factors/radiosity.h"
#include "test_board.h"
#include "test_room.h"

namespace gicube::samples {
namespace {

using reference::kAir;
using reference::kLamp;
using reference::kWall;
using reference::Room;

constexpr const char* kUri = "emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64";

RadiosityResult solve(const Room& room, const Emissions& emissions, const RadiositySettings& settings) {
  Board board = reference::open_board(kUri);
  auto result = solve_radiosity(board, reference::setup_of(room), emissions, settings);
  return result;
}

// Walls that send out E and reflect half, a fog that scatters all: the same radiosity 2 E everywhere.
TEST(Furnace, HasOneRadiosityInAWhiteFog) {
  const auto result = solve({.size = 6, .kappa = 0.2, .wall_albedo = 0.5, .air_albedo = 1}, {{}, {{1, 1, 1}}},
                            {.error = 1e-4, .hierarchy = false});
  for (const Power& out : result.outgoing) EXPECT_NEAR(out[0], 2, 0.02);
  EXPECT_LT(std::abs(result.statistics.energy.closure[0]), 0.005 * result.statistics.energy.emitted[0]);
  EXPECT_LT(result.statistics.closure_rms, 0.002);
}

}  // namespace
}  // namespace gicube::samples
