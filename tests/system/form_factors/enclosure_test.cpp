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
  const auto& s = result.statistics;
  std::printf("faces %lu medium %lu ends %lu clusters %lu links %lu of %lu, pairs %lu rays %lu, closure rms %.5f\n",
              s.faces, s.medium, s.ends, s.clusters, s.links, s.all_pairs, s.pairs, s.rays, s.closure_rms);
  const auto& e = s.energy;
  std::printf("emitted %g faces %g medium %g escaped %g under way %g closure %g; %lu iterations %.2f s\n", e.emitted[0],
              e.absorbed_by_faces[0], e.absorbed_by_medium[0], e.escaped[0], e.under_way[0], e.closure[0],
              s.iterations.size(), s.host_seconds);
  return result;
}

TEST(Furnace, WhiteFog) {
  for (const bool hierarchy : {false, true}) {
    const auto result = solve({.size = 6, .kappa = 0.2, .wall_albedo = 0.5, .air_albedo = 1}, {{}, {{1, 1, 1}}},
                              {.error = 1e-4, .hierarchy = hierarchy});
    double least = 1e9, most = 0;
    for (const Power& out : result.outgoing) least = std::min(least, out[0]), most = std::max(most, out[0]);
    std::printf("%g %g\n", least, most);
  }
}

TEST(Exp, One) {
  const char* e = std::getenv("EXP");
  double kappa, err, step, wa, aa;
  int size, rays, most, hier, leaf;
  if (!e || sscanf(e, "%d,%lf,%lf,%lf,%d,%d,%d,%lf,%lf,%d", &size, &kappa, &wa, &aa, &hier, &rays, &most, &err, &step,
                   &leaf) != 10)
    GTEST_SKIP();
  const auto result =
      solve({.size = size, .kappa = kappa, .wall_albedo = wa, .air_albedo = aa}, {{}, {{1, 1, 1}}},
            {.error = err, .rays = rays, .most_rays = most, .step = step, .hierarchy = hier != 0, .leaf_voxels = leaf});
  double least = 1e9, most_ = 0;
  for (const Power& out : result.outgoing) least = std::min(least, out[0]), most_ = std::max(most_, out[0]);
  std::printf("min %g max %g\n", least, most_);
}

}  // namespace
}  // namespace gicube::samples
