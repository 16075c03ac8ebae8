// A profile on meshes: a plane in even light, and the edge of a shadow on one.
#include "subsurface/surface.h"

#include <gtest/gtest.h>

#include "../../driver/board/test_board.h"
#include "meshes/triangulate.h"
#include "slab.h"

namespace gicube::samples {
namespace {

// exp(-r): its integral over a half plane whose edge is x away has no closed form, but is one integral.
Profile falling() {
  Profile out;
  constexpr int kRings = 200;
  for (int k = 0; k < kRings; ++k) {
    const double inner = 10.0 * k / kRings, outer = 10.0 * (k + 1) / kRings;
    const auto share = [](double a) { return 1 - (1 + a) * std::exp(-a); };  // of exp(-r) / 2 pi
    out.rings.push_back({inner, outer, {0.8 * (share(outer) - share(inner)), 0, 0}, {}});
  }
  return out;
}

Mesh plane(double edge) {
  return refined({{{-16, -16, 0}, {16, -16, 0}, {16, 16, 0}, {-16, 16, 0}}, {{0, 1, 2}, {0, 2, 3}}}, edge);
}

TEST(Subsurface, OfAPlaneInEvenLightReflectsTheProfilesWhole) {
  const Mesh mesh = plane(0.75);
  const auto found = spread_beneath(mesh, Irradiance(mesh.triangles.size(), Rgb{2, 1, 1}), falling(), 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 at = mesh.points[mesh.triangles[t][0]];
    if (std::abs(at.x) > 6 || std::abs(at.y) > 6) continue;
    EXPECT_NEAR(found[t][0], 2 * 0.8, 0.01 * 1.6);
    EXPECT_EQ(found[t][1], 0);
  }
}

// Of what falls on x > 0 the share that comes out at x: integral of the profile's line spread.
TEST(Subsurface, SoftensTheEdgeOfAShadowByTheProfilesLineSpread) {
  const Mesh mesh = plane(0.75);
  Irradiance light;
  std::vector<Vec3> middles;
  for (const auto& [a, b, c] : mesh.triangles) {
    middles.push_back(1.0 / 3 * (mesh.points[a] + mesh.points[b] + mesh.points[c]));
    light.push_back({middles.back().x > 0 ? 1.0 : 0.0, 0, 0});
  }
  const auto found = spread_beneath(mesh, light, falling(), 1);
  const auto truth = [](double x) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {  // over the distances, with the share of the circle that lies beyond the edge
      const double r = 10.0 * (i + 0.5) / kSteps;
      const double beyond = std::acos(std::clamp(-x / r, -1.0, 1.0)) / std::numbers::pi;
      sum += 0.8 * std::exp(-r) * r * beyond * 10 / kSteps;
    }
    return sum;
  };
  int compared = 0;
  for (std::size_t t = 0; t < middles.size(); ++t) {
    if (std::abs(middles[t].x) > 4 || std::abs(middles[t].y) > 5) continue;
    EXPECT_NEAR(found[t][0], truth(middles[t].x), 0.02) << middles[t].x;
    ++compared;
  }
  EXPECT_GT(compared, 100);
}

TEST(Subsurface, IsLitAsLampsAndShadowsSay) {
  Slab slab(reference::open_board(), 0.1, 0.5, 0, 9);
  slab.setup.lights = {PointLight{{24, 24, 20}, 1000}};
  slab.setup.light_colours = {{1, 0.5, 0}};
  const Lights lights(slab.setup, slab.medium);
  PolygonSurface floor{"floor",
                       refined({{{4, 4, 0}, {44, 4, 0}, {44, 44, 0}, {4, 44, 0}}, {{0, 1, 2}, {0, 2, 3}}}, 4),
                       {0.5, 0.5, 0.5},
                       {}};
  PolygonSurface shade{
      "shade", {{{24, 4, 10}, {44, 4, 10}, {44, 44, 10}, {24, 44, 10}}, {{0, 1, 2}, {0, 2, 3}}}, {}, {}};
  const SubsurfacePicture drawn(slab.medium, lights, {floor, shade}, falling(), 1, 1, 4, 1);
  for (std::size_t t = 0; t < floor.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = floor.mesh.triangles[t];
    const Vec3 at = 1.0 / 3 * (floor.mesh.points[a] + floor.mesh.points[b] + floor.mesh.points[c]);
    const double r = length(Vec3{24, 24, 20} - at);
    const double truth = at.x > 24 ? 0 : 1000 * 20 / (4 * std::numbers::pi * r * r * r);
    EXPECT_NEAR(drawn.irradiance(0)[t][0], truth, 1e-9) << at.x;
    EXPECT_NEAR(drawn.irradiance(0)[t][1], truth / 2, 1e-9);
  }
}

}  // namespace
}  // namespace gicube::samples
