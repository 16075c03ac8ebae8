#include "cone_beam/view_rays.h"

#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "small_scan.h"
#include "test.h"
#include "voxels.h"

namespace gicube::samples {
namespace {

// A smooth ball: as much of a Gaussian as voxels can hold.
std::vector<float> bump(const Grid& grid, double offset) {
  std::vector<float> out;
  for_each_voxel(grid.dims, [&](int x, int y, int z) {
    const Vec3 at = to_space(grid, {double(x), double(y), double(z)}) - Vec3{5, 3, -4};
    out.push_back(static_cast<float>(std::exp(-dot(at, at) / (2 * 100)) + offset));
  });
  return out;
}

// Of a Gaussian of deviation 10 along a line that passes it at some distance.
double closed_form(Vec3 source, Vec3 pixel) {
  const Vec3 way = pixel - source, from = Vec3{5, 3, -4} - source;
  const double along = dot(from, way) / length(way), square = dot(from, from) - along * along;
  return std::exp(-square / 200) * 10 * std::sqrt(2 * std::numbers::pi);
}

TEST(Projector, AVolumesProjectionsAreItsLineIntegrals) {
  ConeGeometry geometry = small_scan(32, 5);
  geometry.volume = {{40, 36, 30}, {2.2, 2.5, 2.9}};
  Board board = open_board();
  const Projections made = project_by_board(board, geometry, bump(geometry.volume, 0));
  double worst = 0;
  for (std::size_t view = 0; view < 5; ++view) {
    const ViewPose at = pose(geometry, view);
    for (int j = 8; j < 24; ++j) {
      for (int i = 8; i < 24; ++i) {
        const Vec3 pixel = at.centre + (i - 15.5) * at.u + (j - 15.5) * at.v;
        const double off = double{made.view(view)[j * 32 + i]} - closed_form(at.source, pixel);
        worst = std::max(worst, std::abs(off));
      }
    }
  }
  EXPECT_LT(worst, 0.01 * 10 * std::sqrt(2 * std::numbers::pi));  // a curved thing between straight lines
}

TEST(Projector, ValuesBelowZeroCountToo) {
  const ConeGeometry geometry = small_scan(24, 3);
  Board board = open_board();
  const auto above = project_by_board(board, geometry, bump(geometry.volume, 0));
  const auto below = project_by_board(board, geometry, bump(geometry.volume, -0.5));
  const auto flat = project_by_board(board, geometry, std::vector<float>(24 * 24 * 24, 0.5F));
  for (std::size_t i = 0; i < above.values.size(); ++i) {
    EXPECT_NEAR(double{above.values[i]}, double{below.values[i]} + double{flat.values[i]}, 0.05) << i;
  }
}

TEST(Projector, NothingProjectsToNothing) {
  const ConeGeometry geometry = small_scan(16, 2);
  Board board = open_board();
  const auto made = project_by_board(board, geometry, std::vector<float>(16 * 16 * 16));
  EXPECT_EQ(made.values.size(), 2u * 16 * 16);
  EXPECT_EQ(*std::max_element(made.values.begin(), made.values.end()), 0);
}

TEST(Projector, WhatIsWrongIsNamed) {
  const ConeGeometry geometry = small_scan(16, 2);
  Board board = open_board();
  std::vector<float> volume(16 * 16 * 16);
  EXPECT_THROW(project_by_board(board, geometry, volume, 40), BadArgument);
  volume[3] = std::nanf("");
  EXPECT_THROWS(BadArgument, "volume: expected finite values", project_by_board(board, geometry, volume));
  volume.pop_back();
  EXPECT_THROWS(BadArgument, "volume: expected 4096 values, got 4095", project_by_board(board, geometry, volume));
}

}  // namespace
}  // namespace gicube::samples
