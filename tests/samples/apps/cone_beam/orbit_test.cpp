// Views that lie on no circle: tilted and shifted detectors, and helices; and the conventions of circles.
#include "cone_beam/algebraic.h"
#include "cone_beam/facing.h"
#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

using std::numbers::pi;

double part(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-52 - 1; }  // -1..1

// The scan with each detector tilted about its row, its column and its normal by up to `degrees`, and shifted by up to
// `pixels`.
ConeGeometry shaken(const ConeGeometry& from, double degrees, double pixels) {
  ConeGeometry out = from;
  std::mt19937_64 engine(7);
  for (std::size_t view = 0; view < from.angles.size(); ++view) {
    ViewPose at = pose(from, view);
    const auto turn = [&](Vec3& a, Vec3& b) {
      const double by = degrees * pi / 180 * part(engine), c = std::cos(by), s = std::sin(by);
      const Vec3 turned = c * a + s * b;
      b = c * b - s * a;
      a = turned;
    };
    const double pitch_u = length(at.u), pitch_v = length(at.v);
    Vec3 u = (1 / pitch_u) * at.u, v = (1 / pitch_v) * at.v, n = cross(u, v);
    turn(u, v);
    turn(v, n);
    turn(u, n);
    at.centre = at.centre + pixels * (part(engine) * at.u + part(engine) * at.v);
    at.u = pitch_u * u;
    at.v = pitch_v * v;
    out.poses.push_back(at);
  }
  return out;
}

ConeGeometry wide_scan(int views) {
  ConeGeometry geometry = small_scan(48, views);
  geometry.detector = {60, 60, 200.0 / 48, 200.0 / 48};  // that sees the object however it is shaken
  geometry.volume = {{40, 40, 40}, {2.2, 2.2, 2.2}};
  return geometry;
}

const Phantom kHead = high_contrast_shepp_logan(40);

double error(const ConeGeometry& geometry, const Reconstruction& made, const Phantom& phantom = kHead) {
  return compare(geometry.volume, made.values, voxels(phantom, geometry.volume), {40, 20}).rmse;
}

TEST(Shaken, SartIsAsGoodAsOfACircleWithinATwentieth) {
  const ConeGeometry circle = wide_scan(60), other = shaken(circle, 2, 5);
  const AlgebraicSettings settings{.iterations = 4, .relaxation = 0.3};
  Board board = open_board();
  const double wanted = error(circle, reconstruct_algebraic(board, circle, project(kHead, circle), settings));
  const double found = error(other, reconstruct_algebraic(board, other, project(kHead, other), settings));
  EXPECT_LT(found, 1.05 * wanted);
  // The poses count: taken for the circle's the views make something else.
  EXPECT_GT(error(circle, reconstruct_algebraic(board, circle, project(kHead, other), settings)), 1.5 * wanted);
}

TEST(Shaken, FdkResamplesAndIsAsGoodWithinATenth) {
  const ConeGeometry circle = wide_scan(120), other = shaken(circle, 2, 5);
  Board board = open_board();
  const double wanted = error(circle, reconstruct_fdk(board, circle, project(kHead, circle)));
  EXPECT_LT(error(other, reconstruct_fdk(board, other, project(kHead, other))), 1.1 * wanted);
}

// Three turns, two thirds of the detector's height at the axis each.
ConeGeometry helix(int views) {
  ConeGeometry geometry = small_scan(40, views);
  geometry.detector = {48, 24, 4.5, 4.5};
  geometry.volume = {{36, 36, 64}, {2.5, 2.5, 2.5}};
  for (int i = 0; i < views; ++i) {
    const double angle = i * 3 * 2 * pi / views, height = 36.0 * 3 * (i + 0.5) / views - 54;
    const Vec3 out{std::cos(angle), std::sin(angle), 0}, along{-out.y, out.x, 0}, up{0, 0, height};
    geometry.angles[static_cast<std::size_t>(i)] = angle;
    geometry.poses.push_back({400.0 * out + up, -400.0 * out + up, 4.5 * along, {0, 0, 4.5}});
  }
  return geometry;
}

TEST(Helix, OfThreeTurnsGivesItsPhantom) {
  const ConeGeometry geometry = helix(120);
  // Taller than any view sees: a rod, and balls and a disc along it, off the axis.
  const Phantom phantom{{0.5, {32, 28, 65}, {}, 0.3},
                        {0.5, {8, 8, 8}, {15, 5, -38}, 0},
                        {0.5, {7, 7, 7}, {-12, -9, 2}, 0},
                        {-0.4, {12, 9, 9}, {4, 12, 35}, 0.5}};
  Board board = open_board();
  const Projections views = project(phantom, geometry);
  const Reconstruction found = reconstruct_algebraic(
      board, geometry, views, {.method = Method::kOsSart, .iterations = 8, .subsets = 12, .relaxation = 0.8});
  EXPECT_FALSE(found.diverged);
  const Comparison off = compare(geometry.volume, found.values, voxels(phantom, geometry.volume), {38, 50});
  EXPECT_LT(off.relative_l2, 0.16);
  EXPECT_NEAR(off.bias, 0, 0.005);
  EXPECT_THROWS(BadArgument, "poses[0].source: expected a place on the circle of radius 400 about z",
                reconstruct_fdk(board, geometry, views));
}

TEST(Facing, OfACirclesOwnPosesIsTheCircle) {
  const ConeGeometry circle = small_scan(24, 12);
  ConeGeometry poses = circle;
  for (std::size_t view = 0; view < 12; ++view) poses.poses.push_back(pose(circle, view));
  const Projections views = project(kHead, circle);
  const FacingViews same = facing(poses, views);
  EXPECT_NEAR(same.geometry.source_to_detector, 800, 1e-9);
  ASSERT_EQ(same.projections.values.size(), views.values.size());
  for (std::size_t i = 0; i < views.values.size(); ++i) EXPECT_NEAR(same.projections.values[i], views.values[i], 1e-3);
}

// A ball off all axes: by the formulas of a circle, which this repeats with numbers alone.
TEST(Conventions, ABallOffAllAxesIsSeenWhereTheCirclePutsIt) {
  ConeGeometry geometry = small_scan(64, 8);
  geometry.detector.offset_u = 7;
  geometry.detector.offset_v = -5;
  const Vec3 ball{21, -8, 13};
  const Projections views = project({{1, {4, 4, 4}, ball, 0}}, geometry);
  for (std::size_t view = 0; view < 8; ++view) {
    const double b = geometry.angles[view], c = std::cos(b), s = std::sin(b);
    const double depth = 400 - (ball.x * c + ball.y * s);
    const double u = 800 / depth * (ball.y * c - ball.x * s), v = 800 / depth * ball.z;
    double column = 0, row = 0, sum = 0;
    for (std::size_t i = 0; i < views.view_size(); ++i) {
      const double value = double{views.view(view)[i]};
      column += value * double(i % 64);
      row += value * double(i / 64);
      sum += value;
    }
    EXPECT_NEAR(column / sum, 31.5 + (u - 7) / 3.125, 0.1) << view;
    EXPECT_NEAR(row / sum, 31.5 + (v + 5) / 3.125, 0.1) << view;
  }
}

}  // namespace
}  // namespace gicube::samples
