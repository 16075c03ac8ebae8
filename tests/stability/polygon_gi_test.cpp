// Polygons and zones: how far one radiosity for a whole zone is off.
#include <gtest/gtest.h>

#include "../samples/polygon_gi/small_medium.h"
#include "stability.h"

namespace gicube::stability {
namespace {

// Light that crosses a zone is spread all over it, so thick zones let too much through.
TEST(StabilityOfPolygonGi, ThickZonesLetTooMuchThrough) {
  samples::Fog filled(open_board("emu:"), 0.25, 1, 25, 5);
  const auto [truth, error] = samples::plate_truth(4, 1'000'000);
  const auto off = [&, exact = truth](int zone) { return samples::plate_flux(filled, 4, zone, 1600) / exact - 1; };
  const double quarter = off(1), half = off(2), whole = off(4);
  record("optical_depth_1/4", quarter);
  record("optical_depth_1/2", half);
  record("optical_depth_1", whole);
  EXPECT_LT(std::abs(quarter), 0.01);
  EXPECT_GT(whole, 0.03);
  EXPECT_LT(whole, 0.1);
  EXPECT_LT(error, 0.002 * truth);
}

// A wall of one polygon, thinner than a zone that lies on both its sides: the zone's light is on both sides.
TEST(StabilityOfPolygonGi, ZonesLeakThroughThinWalls) {
  samples::Fog filled(open_board("emu:"), 0.05, 1, 17, 17);
  const auto behind = [&](double wall) {
    std::vector<samples::PolygonSurface> surfaces{samples::patch({1, 4, 4}, {0, 8, 0}, {0, 0, 8}, 0, 1),
                                                  samples::patch({wall, 0, 0}, {0, 16, 0}, {0, 0, 16}),
                                                  samples::patch({15, 4, 4}, {0, 0, 8}, {0, 8, 0})};
    samples::PolygonGi light(filled.board, filled.medium, surfaces, {.rays = 4000, .zone = 4});
    light.solve();
    double sum = 0;
    for (std::size_t i = 0; i < light.elements().size(); ++i) {
      const auto& element = light.elements()[i];
      if (!element.zone && element.surface == 2 && !element.back) sum += light.incident()[i][0] / 2;
    }
    return sum;
  };
  const double between = behind(8), across = behind(6);
  record("wall_between_zones", between);
  record("wall_within_zones", across);
  EXPECT_EQ(between, 0);
  EXPECT_GT(across, 1e-4);
}

}  // namespace
}  // namespace gicube::stability
