// Light between polygons through a medium, against closed forms.
#include "polygon_gi/polygon_gi.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "../../driver/board/test_board.h"
#include "gicube/scene/error.h"
#include "meshes/triangulate.h"
#include "small_medium.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;

Fog fog(double extinction, double albedo, int size = 33) { return {reference::open_board(), extinction, albedo, size}; }

// Standard error of a share of n rays that fall at random; strata make it less.
double random_error(double share, double n) { return std::sqrt(share * (1 - share) / n); }

// Howell's catalogue, C-11: equal parallel rectangles, x and y their sides over the distance.
double parallel_factor(double x, double y) {
  const double a = 1 + x * x, b = 1 + y * y;
  return 2 / (kPi * x * y) *
         (std::log(std::sqrt(a * b / (a + y * y))) + x * std::sqrt(b) * std::atan(x / std::sqrt(b)) +
          y * std::sqrt(a) * std::atan(y / std::sqrt(a)) - x * std::atan(x) - y * std::atan(y));
}

// C-14: perpendicular rectangles with a common edge; h and w their other sides over it.
double perpendicular_factor(double h, double w) {
  const double h2 = h * h, w2 = w * w, s = h2 + w2;
  const double logs = std::log((1 + w2) * (1 + h2) / (1 + s)) + w2 * std::log(w2 * (1 + s) / ((1 + w2) * s)) +
                      h2 * std::log(h2 * (1 + s) / ((1 + h2) * s));
  return (w * std::atan(1 / w) + h * std::atan(1 / h) - std::sqrt(s) * std::atan(1 / std::sqrt(s)) + logs / 4) /
         (kPi * w);
}

// Two parallel unit squares one apart, through an extinction of kappa a side: their points' differences have a triangular law, so it is an
// integral over two dimensions.
double parallel_in_fog(double kappa) {
  constexpr int kPlaces = 1000;
  double sum = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const double x = (i % kPlaces + 0.5) / kPlaces, y = (i / kPlaces + 0.5) / kPlaces, r2 = x * x + y * y + 1;
    sum += 4 * (1 - x) * (1 - y) * std::exp(-kappa * std::sqrt(r2)) / (kPi * r2 * r2);
  }
  return sum / kPlaces / kPlaces;
}

// The same with a common edge: along it a triangular law, across it both distances.
double perpendicular_in_fog(double kappa) {
  constexpr int kPlaces = 200;
  double sum = 0;
  for (int i = 0; i < kPlaces; ++i) {
    for (int j = 0; j < kPlaces; ++j) {
      for (int k = 0; k < kPlaces; ++k) {
        const double x = (i + 0.5) / kPlaces, a = (j + 0.5) / kPlaces, b = (k + 0.5) / kPlaces;
        const double r2 = x * x + a * a + b * b;
        sum += 2 * (1 - x) * a * b * std::exp(-kappa * std::sqrt(r2)) / (kPi * r2 * r2);
      }
    }
  }
  return sum / std::pow(kPlaces, 3);
}

TEST(PolygonRows, HaveTheFormFactorsOfRectangles) {
  Fog clear = fog(0, 0);
  constexpr int kRays = 40000;
  PolygonGi light(clear.board, clear.medium,
                  {patch({4, 4, 4}, {12, 0, 0}, {0, 6, 0}), patch({4, 4, 16}, {0, 6, 0}, {12, 0, 0}),
                   patch({16, 4, 4}, {0, 0, 9}, {0, 6, 0})},
                  {.rays = kRays});
  const double parallel = parallel_factor(1, 0.5), perpendicular = perpendicular_factor(9.0 / 6, 12.0 / 6);
  EXPECT_NEAR(factor(light, 0, 1), parallel, 3 * random_error(parallel, 2 * kRays));
  EXPECT_NEAR(factor(light, 0, 2), perpendicular, 3 * random_error(perpendicular, 2 * kRays));
  EXPECT_NEAR(factor(light, 1, 0), parallel, 3 * random_error(parallel, 2 * kRays));
  EXPECT_NEAR(perpendicular_factor(1, 1), 0.200044, 1e-6);
  EXPECT_NEAR(parallel_factor(1, 1), 0.199825, 1e-6);
}

// A law of large numbers for rows of few rays, also of those that make no square of strata.
TEST(PolygonRows, HaveTheFormFactorsOfRectanglesInTheMeanOfManyRowsOfAnyLength) {
  Fog clear = fog(0, 0, 17);
  const double truth = perpendicular_factor(9.0 / 6, 12.0 / 6);
  for (const int rays : {16, 30, 35}) {
    constexpr int kSeeds = 100;
    double sum = 0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      PolygonGi light(clear.board, clear.medium,
                      {patch({4, 4, 4}, {12, 0, 0}, {0, 6, 0}), patch({16, 4, 4}, {0, 0, 9}, {0, 6, 0})},
                      {.rays = rays, .seed = seed});
      sum += factor(light, 0, 1);
    }
    EXPECT_NEAR(sum / kSeeds, truth, 3 * random_error(truth, 2.0 * rays * kSeeds)) << rays;
  }
}

TEST(PolygonRows, AreAttenuatedByTheFogBetween) {
  constexpr int kRays = 40000;
  for (const double kappa : {0.5, 2.0}) {  // a side of 8
    Fog filled = fog(kappa / 8, 0.5);
    PolygonGi light(filled.board, filled.medium,
                    {patch({8, 8, 8}, {8, 0, 0}, {0, 8, 0}), patch({8, 8, 16}, {0, 8, 0}, {8, 0, 0}),
                     patch({16, 8, 8}, {0, 0, 8}, {0, 8, 0})},
                    {.rays = kRays});
    const double parallel = parallel_in_fog(kappa), perpendicular = perpendicular_in_fog(kappa);
    EXPECT_NEAR(factor(light, 0, 1), parallel, 3 * random_error(parallel, 2 * kRays)) << kappa;
    EXPECT_NEAR(factor(light, 0, 2), perpendicular, 3 * random_error(perpendicular, 2 * kRays)) << kappa;
  }
}

// What a zone sends to a surface is what the surface sends to the zone, times their weights.
TEST(PolygonRows, AreReciprocalBetweenSurfacesAndZones) {
  Fog filled = fog(0.05, 0.5, 17);
  PolygonGi light(filled.board, filled.medium, {patch({4, 4, 6}, {8, 0, 0}, {0, 8, 0})}, {.rays = 60000, .zone = 4});
  const auto& elements = light.elements();
  std::vector<std::uint32_t> all{0};  // the front of a triangle
  for (std::uint32_t i = 0; i < elements.size(); ++i) {
    if (elements[i].zone && i % 5 == 0) all.push_back(i);
  }
  const auto rows = light.rows(all);
  const auto share = [](const PolygonGi::Row& row, std::uint32_t of) {
    const auto found = std::ranges::find(row.shares, of, &std::pair<std::uint32_t, float>::first);
    return found == row.shares.end() ? 0.0 : static_cast<double>(found->second);
  };
  int compared = 0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    const double there = elements[0].weight * share(rows[0], all[k]),
                 back = elements[all[k]].weight * share(rows[k], 0);
    const double error = std::hypot(elements[0].weight * random_error(share(rows[0], all[k]), 60000),
                                    elements[all[k]].weight * random_error(share(rows[k], 0), 60000));
    EXPECT_NEAR(there, back, 4 * error + 1e-9) << all[k];
    compared += there > 0 ? 1 : 0;
  }
  EXPECT_GT(compared, 3);
}

PolygonSurface room(double albedo, double emission) {
  PolygonSurface out;
  out.mesh = refined(mesh_of(BoxShape{{0, 0, 0}, {16, 16, 16}}), 6);
  for (auto& triangle : out.mesh.triangles) std::swap(triangle[0], triangle[1]);  // inwards
  out.albedo = {albedo, albedo / 2, 0};
  for (std::size_t c = 0; c < 3; ++c) out.emission[c] = emission * (1 - out.albedo[c]);
  return out;
}

// What sends out one less than its albedo, and what absorbs nothing, has a radiosity of one everywhere. Light from one element to another is exact;
// what comes straight from emitters is not.
TEST(PolygonGi, IsOneInAFurnace) {
  for (const double extinction : {0.0, 0.1}) {
    Fog filled = fog(extinction, 1, 17);
    PolygonGi light(filled.board, filled.medium, {room(0.8, 1)}, {.rays = 400, .convergence = 1e-6});
    light.solve();
    Rgb sum{};
    double weights = 0, zones = 0;
    for (std::size_t i = 0; i < light.elements().size(); ++i) {
      const GiElement& element = light.elements()[i];
      if (element.dark) continue;
      zones += element.zone ? 1 : 0;
      weights += element.weight;
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(light.radiosity()[i][c], 1, 0.1);
        sum[c] += element.weight * light.radiosity()[i][c];
      }
    }
    for (const double part : sum) EXPECT_NEAR(part / weights, 1, 0.004);
    EXPECT_EQ(zones > 0, extinction > 0);
    View view = filled.setup.view;
    view.eye = {8, 8, 8}, view.look_at = {8, 12, 9}, view.width = view.height = 8, view.fov_degrees = 60;
    for (const Rgb& pixel : light.picture(view, 4).mean) {
      for (const double part : pixel) EXPECT_NEAR(kPi * part, 1, 0.05);
    }
  }
}

TEST(PolygonGi, AccountsForItsPower) {
  Fog filled = fog(0.05, 0.6, 17);
  PolygonSurface lamp = patch({6, 6, 15}, {0, 4, 0}, {4, 0, 0}, 0, 10);
  PolygonSurface floor = patch({2, 2, 2}, {12, 0, 0}, {0, 12, 0}, 0.7);
  floor.mesh = refined(floor.mesh, 4);
  PolygonGi light(filled.board, filled.medium, {lamp, floor}, {.rays = 1000});
  light.solve();
  const PolygonGiStatistics s = light.statistics();
  EXPECT_NEAR(s.emitted[0], 16 * 10, 1e-9);
  EXPECT_NEAR((s.absorbed_by_surfaces[0] + s.absorbed_by_medium[0] + s.escaped[0]) / s.emitted[0], 1, 0.01);
  EXPECT_GT(s.absorbed_by_surfaces[0], 0.05 * s.emitted[0]);
  EXPECT_GT(s.absorbed_by_medium[0], 0.05 * s.emitted[0]);
  EXPECT_GT(s.escaped[0], 0.2 * s.emitted[0]);
}

PolygonSurface box(Vec3 low, Vec3 high, double edge, double emission = 0) {
  return {"box", refined(mesh_of(BoxShape{low, high}), edge), {}, {emission, emission, emission}};
}

// Six black walls that overlap along all edges, at corners three of them, and a lamp that is let into the floor: the room
// absorbs what the lamp sends out, and that is what of its area is in the open.
TEST(PolygonGi, AbsorbsInAClosedRoomOfOverlappingBoxesWhatTheLampEmits) {
  Fog clear = fog(0, 0, 17);
  std::vector<PolygonSurface> surfaces;
  for (const auto& [low, high] : {std::pair{Vec3{0, 0, 0}, Vec3{16, 16, 2}},
                                  {Vec3{0.1, 0.1, 14}, Vec3{15.9, 15.9, 16}},
                                  {Vec3{0.2, 0.2, 0.2}, Vec3{2, 15.8, 15.8}},
                                  {Vec3{14, 0.3, 0.3}, Vec3{15.7, 15.7, 15.7}},
                                  {Vec3{0.4, 0.4, 0.4}, Vec3{15.6, 2, 15.6}},
                                  {Vec3{0.5, 14, 0.5}, Vec3{15.5, 15.5, 15.5}}}) {
    surfaces.push_back(box(low, high, 3));
  }
  surfaces.push_back(box({6, 6, 1}, {10, 10, 4}, 3, 3));
  PolygonGi light(clear.board, clear.medium, surfaces, {.rays = 400});
  light.solve();
  const PolygonGiStatistics s = light.statistics();
  const double emitted = 3 * (4 * 4 + 4 * 4 * 2);
  EXPECT_NEAR(s.emitted[0], emitted, 0.01 * emitted);
  EXPECT_NEAR(s.absorbed_by_surfaces[0], emitted, 0.015 * emitted);
  EXPECT_NEAR(s.escaped[0], 0, 1e-3 * emitted);
}

// A block that a zone reaches into takes no light from the zone.
TEST(PolygonGi, LeavesOutWhatOfAZoneIsInASolid) {
  Fog filled = fog(0.1, 1, 17);
  const auto seen = [&](bool with_block) {
    PolygonSurface shell = room(0, 1);
    std::vector<PolygonSurface> surfaces{shell};
    if (with_block) surfaces.push_back({"block", refined(mesh_of(BoxShape{{2, 2, 4}, {14, 14, 6}}), 6), {1, 1, 1}, {}});
    PolygonGi light(filled.board, filled.medium, surfaces, {.rays = 1000});
    light.solve();
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < light.elements().size(); ++i) {
      const GiElement& element = light.elements()[i];
      if (!element.zone || element.triangle / 16 != 1) continue;  // from z = 4 to 8
      sum += element.weight * light.radiosity()[i][0];
      weights += element.weight;
    }
    return std::pair{sum / weights, weights};
  };
  const auto [open, whole] = seen(false);
  const auto [blocked, left] = seen(true);
  EXPECT_NEAR(open, 1, 0.02);
  EXPECT_NEAR(blocked, 1, 0.02);
  EXPECT_NEAR(left / whole, 1 - 144 * 2 / (256.0 * 4), 0.02);
}

// Between black plates 24 wide and 4 apart, through a medium of optical depth 1 that scatters all and absorbs nothing. (Of wide plates'
// light 0.5532 arrives: Heaslet and Warming 1965.)
TEST(PolygonGi, FindsTheFluxBetweenPlatesThroughAScatteringMedium) {
  Fog filled{reference::open_board(), 0.25, 1, 25, 5};
  const auto [truth, error] = plate_truth(4, 1'000'000);
  EXPECT_NEAR(truth, 0.5532, 0.05 * 0.5532);
  EXPECT_NEAR(plate_flux(filled, 4, 1, 400), truth, 3 * error + 0.01 * truth);
}

TEST(PolygonGi, RefusesSolidsInTheVolumeAndForwardScattering) {
  const auto refused = [](const std::string& material) {
    Scene scene = parse_scene(
        "world { size: 9 node { material: \"a\" sphere { radius: 0.5 } } } material { name: \"a\" " + material + " }",
        "x", ".");
    const SceneSetup setup = set_up(scene, 1);
    Board board = reference::open_board();
    const Medium medium(board, setup);
    try {
      PolygonGi(board, medium, {patch({0, 0, 0}, {1, 0, 0}, {0, 1, 0})}, {});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refused("solid { } scattering: 0.5 bsdf: \"diffuse\""),
            "material of tag 0.bsdf: expected none or isotropic within the volume, got a solid's");
  EXPECT_EQ(
      refused("fog { extinction: 1 } scattering: 0.5 bsdf: \"trap\" routine: \"henyey_greenstein\" parameter: 0.5"),
      "material of tag 0.parameter: expected 0: media scatter evenly here, got 0.500000");
}

}  // namespace
}  // namespace gicube::samples
