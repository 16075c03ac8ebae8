// Photon maps by the board against the double-precision path tracer of tests/support.
#include "light/photon_map/photon_map.h"

#include "../../../../driver/board/test_board.h"
#include "../path/light_scenes.h"
#include "reference/paths/path_tracer.h"
#include "test.h"

namespace gicube::samples {
namespace {

std::vector<Photon> random_photons(int count) {
  PathRandom random(5, 0);
  std::vector<Photon> out;
  for (int i = 0; i < count; ++i) {
    out.push_back(
        {{10 * random.uniform(), 10 * random.uniform(), 10 * random.uniform()}, random.direction(), {1, 1, 1}});
  }
  return out;
}

TEST(PhotonTree, FindsTheNearestAsASearchOfAllDoes) {
  const std::vector<Photon> photons = random_photons(3000);
  const PhotonTree tree(photons);
  PathRandom random(6, 0);
  for (int i = 0; i < 50; ++i) {
    const Vec3 place{10 * random.uniform(), 10 * random.uniform(), 10 * random.uniform()};
    std::vector<double> distances;
    for (const Photon& photon : photons) distances.push_back(length(photon.place - place));
    std::ranges::sort(distances);
    const auto near = tree.nearest(place, 20, 100);
    ASSERT_EQ(near.photons.size(), 19u);
    EXPECT_NEAR(near.radius, distances[19], 1e-12);
    for (const Photon* photon : near.photons) EXPECT_LE(length(photon->place - place), distances[18] + 1e-12);
    const auto within = tree.nearest(place, 3000, 1.5);
    EXPECT_EQ(within.radius, 1.5);
    EXPECT_EQ(within.photons.size(),
              static_cast<std::size_t>(std::ranges::count_if(distances, [](double d) { return d < 1.5; })));
  }
  EXPECT_TRUE(PhotonTree({}).nearest({}, 20, 1).photons.empty());
}

// Away from the faces of an even cloud the mean of count / volume is the true density.
TEST(PhotonTree, TellsADensityWithoutBias) {
  const PhotonTree tree(random_photons(20000));
  PathRandom random(7, 0);
  double sum = 0, squares = 0;
  constexpr int kPlaces = 2000;
  for (int i = 0; i < kPlaces; ++i) {
    const Vec3 place{3 + 4 * random.uniform(), 3 + 4 * random.uniform(), 3 + 4 * random.uniform()};
    const auto near = tree.nearest(place, 12, 3);
    const double density =
        static_cast<double>(near.photons.size()) / (4.0 / 3 * std::numbers::pi * std::pow(near.radius, 3));
    sum += density, squares += density * density;
  }
  const double mean = sum / kPlaces, error = std::sqrt((squares / kPlaces - mean * mean) / kPlaces);
  // Places share photons: 64 balls of twelve fill what the places are in, 100 times.
  EXPECT_NEAR(mean, 20, 3 * error * std::sqrt(2000.0 / 100));
}

using Halves = std::array<double, 6>;  // the upper half's and the lower half's mean, by channel

Halves halves_of(const std::vector<Rgb>& pixels) {
  Halves out{};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      out[(2 * i >= pixels.size() ? 3 : 0) + c] += 2 * pixels[i][c] / static_cast<double>(pixels.size());
  }
  return out;
}

struct Estimates {
  Halves mean{}, error{};
};

Estimates by_photons(const LightScene& scene, const PhotonSettings& settings, std::uint64_t pictures) {
  const SceneSetup setup = setup_of(scene);
  Board board = Board::open("emu:");
  const Medium medium(board, setup);
  const Lights lights(setup, medium);
  std::vector<Halves> all;
  Estimates out;
  for (std::uint64_t i = 0; i < pictures; ++i) {
    PhotonSettings own = settings;
    own.seed = 300 + i;
    PhotonMapping mapping(board, medium, lights, setup.view, own);
    mapping.pass();
    all.push_back(halves_of(mapping.picture().mean));
    for (std::size_t k = 0; k < 6; ++k) out.mean[k] += all.back()[k] / static_cast<double>(pictures);
  }
  const auto n = static_cast<double>(pictures);
  for (std::size_t k = 0; k < 6; ++k) {
    for (const Halves& one : all) out.error[k] += std::pow(one[k] - out.mean[k], 2) / (n - 1) / n;
    out.error[k] = std::sqrt(out.error[k]);
  }
  return out;
}

Estimates by_reference(const LightScene& scene, std::uint64_t paths) {
  const SceneSetup setup = setup_of(scene);
  reference::paths::PathScene wanted = to_paths(setup);
  wanted.max_scatterings = 24;
  const auto picture = reference::paths::PathTracer(wanted).render(paths, 8);
  std::vector<Rgb> mean, variance;
  for (const auto& pixel : picture.pixels) {
    mean.push_back({pixel[0].mean, pixel[1].mean, pixel[2].mean});
    variance.push_back(
        {pixel[0].error * pixel[0].error, pixel[1].error * pixel[1].error, pixel[2].error * pixel[2].error});
  }
  Estimates out{halves_of(mean), halves_of(variance)};
  for (double& error : out.error) error = std::sqrt(error * 2 / static_cast<double>(mean.size()));
  return out;
}

// The blur of a density is a bias: within `bias` of the light.
void expect_alike(const Estimates& found, const Estimates& truth, double bias) {
  for (std::size_t k = 0; k < 6; ++k) {
    const double error = std::hypot(found.error[k], truth.error[k]);
    EXPECT_NEAR(found.mean[k], truth.mean[k], 3 * error + bias * truth.mean[k]) << "part " << k << ", error " << error;
    EXPECT_LT(error, 0.05 * truth.mean[k]) << "part " << k;
  }
}

TEST(PhotonMaps, OfFogHaveTheReferencesLight) {
  expect_alike(by_photons(fog_scene(), {.photons = 20000, .neighbours = 40, .max_scatterings = 24}, 10),
               by_reference(fog_scene(), 60), 0.05);
}

TEST(PhotonMaps, OfWallsInFogHaveTheReferencesLight) {
  expect_alike(by_photons(room_scene(), {.photons = 20000, .neighbours = 40, .max_scatterings = 24}, 10),
               by_reference(room_scene(), 30), 0.05);
}

TEST(PhotonMaps, OfGlassHaveTheReferencesCaustic) {
  expect_alike(by_photons(glass_scene(), {.photons = 20000, .neighbours = 40, .max_scatterings = 24}, 10),
               by_reference(glass_scene(), 20), 0.05);
}

}  // namespace
}  // namespace gicube::samples
