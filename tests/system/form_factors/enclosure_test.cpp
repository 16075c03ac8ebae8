// Radiosity in closed rooms, where all light is accounted for.
#include <iostream>

#include "form_factors/plan/plan.h"
#include "form_factors/radiosity/radiosity.h"
#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"
#include "test_board.h"
#include "test_room.h"

namespace gicube::samples {
namespace {

using reference::kAir;
using reference::kLamp;
using reference::kObstacle;
using reference::kWall;
using reference::Room;

constexpr const char* kUri = "emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64";

RadiosityResult solve(const SceneSetup& setup, const Emissions& emissions, const RadiositySettings& settings) {
  Board board = Board::open(kUri);
  return solve_radiosity(board, setup, emissions, settings);
}
RadiosityResult solve(const Room& room, const Emissions& emissions, const RadiositySettings& settings) {
  return solve(reference::setup_of(room), emissions, settings);
}

const Emissions kWalls{{}, {{1, 1, 1}}};
const Emissions kCeilingLamp{{}, {}, {{3, 2, 1}}};

// A lamp in the ceiling, a block on the floor.
Room furnished(int size, double kappa) {
  Room room{.size = size, .kappa = kappa, .wall_albedo = 0.6, .air_albedo = 0.6};
  room.tag = [room](int x, int y, int z) -> std::uint8_t {
    const auto middle = [&](int at) { return std::abs(2 * at - room.size - 1) <= room.size / 2; };
    const auto block = [&](int at) { return at > room.size / 4 && at <= room.size / 2; };
    if (z == room.size + 1 && middle(x) && middle(y)) return kLamp;
    if (block(x) && block(y) && z > 0 && z <= room.size / 2) return kObstacle;
    return reference::room_tag(room, x, y, z);
  };
  return room;
}

double share(double power, const EnergyBalance& energy) { return power / energy.emitted[0]; }

// Walls that send out E and reflect half, a fog that scatters all: the same radiosity 2 E everywhere.
TEST(Furnace, HasOneRadiosityInAWhiteFog) {
  const Room room{.size = 6, .kappa = 0.2, .wall_albedo = 0.5, .air_albedo = 1};
  for (const bool hierarchy : {false, true}) {
    const auto result = solve(room, kWalls, {.error = 1e-4, .hierarchy = hierarchy});
    for (const Power& out : result.outgoing) EXPECT_NEAR(out[0], 2, 0.001) << hierarchy;
  }
  const auto measured = solve(room, kWalls, {.rays = 16, .hierarchy = false, .balance = false});
  for (const Power& out : measured.outgoing) EXPECT_NEAR(out[0], 2, 0.005);
}

TEST(Enclosure, SumsOfExchangeAreasClose) {
  const auto clear = solve(Room{.size = 6, .wall_albedo = 0.5}, kWalls, {.hierarchy = false});
  EXPECT_LT(clear.statistics.closure_rms, 1e-4);
  for (const double kappa : {0.0, 0.1}) {
    const auto result =
        solve(furnished(6, kappa), kCeilingLamp, {.rays = 64, .step = 1.0 / 16, .hierarchy = false, .balance = false});
    EXPECT_LT(result.statistics.closure_rms, 0.005) << kappa;
    EXPECT_LT(std::abs(share(result.statistics.energy.closure[0], result.statistics.energy)), 0.005) << kappa;
  }
}

TEST(Enclosure, EmittedPowerIsAbsorbed) {
  for (const bool balance : {false, true}) {
    const auto result =
        solve(furnished(8, 0.1), kCeilingLamp, {.error = 1e-5, .hierarchy = balance, .balance = balance});
    const EnergyBalance& energy = result.statistics.energy;
    EXPECT_EQ(result.statistics.ends, 0u);
    EXPECT_GT(share(energy.absorbed_by_medium[0], energy), 0.1);
    for (std::size_t c = 0; c < 3; ++c) {
      const double absorbed = energy.absorbed_by_faces[c] + energy.absorbed_by_medium[c];
      EXPECT_NEAR(absorbed / energy.emitted[c], 1, balance ? 0.0005 : 0.005) << c;
      EXPECT_NEAR(absorbed + energy.escaped[c] + energy.under_way[c] + energy.closure[c], energy.emitted[c],
                  1e-6 * energy.emitted[c]);
    }
    EXPECT_NEAR(energy.absorbed_by_faces[0] / 3, energy.absorbed_by_faces[2], 1e-3 * energy.emitted[2]);
  }
}

// How far the sums of a file's elements are from 1, with the rows of the clusters that they are a part of.
double rows_off(const std::filesystem::path& file) {
  std::vector<double> sums, weights;
  std::vector<std::size_t> parents, leaves;
  std::ifstream table(clusters_file(file));
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::vector<std::string> words;
    for (std::istringstream rest(line); std::getline(rest, line, ',');) words.push_back(line);
    weights.push_back(std::stod(words[10])), parents.push_back(std::stoul(words[13]));
  }
  sums.resize(weights.size());
  std::ifstream matrix(file);
  while (matrix.peek() == '%') std::getline(matrix, line);
  std::size_t rows = 0, columns = 0, entries = 0, row = 0, column = 0;
  double exchange = 0;
  matrix >> rows >> columns >> entries;
  EXPECT_EQ(rows, weights.size());
  while (matrix >> row >> column >> exchange) {
    sums[row - 1] += exchange / weights[row - 1];
    if (row != column) sums[column - 1] += exchange / weights[column - 1];
  }
  std::vector<bool> divided(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    if (parents[i] == 0) continue;
    sums[i] += sums[parents[i] - 1];
    divided[parents[i] - 1] = true;
  }
  double off = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (!divided[i]) off = std::max(off, std::abs(sums[i] - 1));
  }
  return off;
}

TEST(Enclosure, RowsOfTheWrittenMatrixSumToOne) {
  const reference::TemporaryDirectory folder;
  for (const double error : {1e-2, 1e-3}) {
    const auto result = solve(furnished(8, 0.1), kCeilingLamp, {.error = error});
    write_factors(result, folder.file("factors.mtx"));
    EXPECT_LT(rows_off(folder.file("factors.mtx")), 0.01) << error;
    EXPECT_GT(result.statistics.closure_rms, 0.05) << error;  // as measured
  }
}

TEST(Enclosure, ShootingAndGatheringAgree) {
  const RadiositySettings settings{.error = 1e-4, .convergence = 1e-6};
  auto other = settings;
  other.solver = Solver::kShooting;
  const auto gathered = solve(furnished(8, 0.05), kCeilingLamp, settings);
  const auto shot = solve(furnished(8, 0.05), kCeilingLamp, other);
  EXPECT_LT(difference(shot, gathered), 1e-3);  // links differ where a radiosity is just at the threshold
  EXPECT_LE(shot.statistics.iterations.back().residual, 1e-6);
}

TEST(Enclosure, ABrightRoomHasNoLightBehindAClosedWall) {
  Room room = furnished(6, 0.05);
  room.tag = [size = room.size, room](int x, int y, int z) -> std::uint8_t {
    if (z == size / 2) return kWall;
    if (z == size + 1 && x == 4 && y == 4) return kLamp;
    return reference::room_tag(room, x, y, z);
  };
  for (const bool hierarchy : {false, true}) {
    const auto result = solve(room, kCeilingLamp, {.error = 1e-5, .hierarchy = hierarchy});
    double dark = 0, lit = 0;
    for (std::size_t i = 0; i < result.leaves.size(); ++i) {
      (result.leaves[i].cell[2] < room.size / 2 ? dark : lit) += result.leaves[i].weight * result.incident[i][0];
    }
    // A link of large clusters on both sides may stay undivided if it misplaces little.
    EXPECT_LE(dark, hierarchy ? 1e-3 * lit : 0) << hierarchy;
    EXPECT_GT(lit, 3);
  }
}

// kappa P e^(-kappa r) / (4 pi r^2) is absorbed a unit of volume.
TEST(Enclosure, AGlowingVoxelLightsAnAbsorberAsAPointDoes) {
  constexpr double kKappa = 0.1;
  Room room{.size = 15, .kappa = kKappa};
  room.tag = [room](int x, int y, int z) -> std::uint8_t {
    return x == 8 && y == 8 && z == 8 ? std::uint8_t{kLamp} : reference::room_tag(room, x, y, z);
  };
  SceneSetup setup = reference::setup_of(room);
  for (auto& value : setup.volume.samples) value = std::byte{0};
  setup.materials[kWall].function.opacities = {{0, 1}};
  setup.materials[kLamp] = setup.materials[kAir];
  const auto result = solve(setup, {{}, {}, {{}, {3, 2, 1}}}, {.error = 1e-6});
  double off = 0, all = 0;
  for (std::size_t i = 0; i < result.leaves.size(); ++i) {
    const Leaf& leaf = result.leaves[i];
    const double x = leaf.cell[0] - 8, y = leaf.cell[1] - 8, z = leaf.cell[2] - 8, r = std::sqrt(x * x + y * y + z * z);
    if (leaf.facing != kMedium || r < 3) continue;
    const double expected = kKappa * 3 * std::exp(-kKappa * r) / (4 * std::numbers::pi * r * r);
    EXPECT_NEAR(leaf.weight * result.incident[i][0], expected, 0.25 * expected) << r;
    off += std::abs(leaf.weight * result.incident[i][0] - expected);
    all += expected;
  }
  EXPECT_LT(off, 0.02 * all);
  EXPECT_GT(all, 0.3 * 3);
}

TEST(Enclosure, OpenOnesLetLightOut) {
  Room room{.size = 6, .wall_albedo = 0.5};
  room.tag = [room](int x, int y, int z) -> std::uint8_t {
    if (z == 0 && x > 0 && y > 0 && x <= room.size && y <= room.size) return kLamp;
    return z == 0 ? std::uint8_t{kWall} : std::uint8_t{kAir};
  };
  const auto result = solve(room, kCeilingLamp, {.error = 1e-4});
  const EnergyBalance& energy = result.statistics.energy;
  EXPECT_GT(result.statistics.ends, 0u);
  EXPECT_NEAR(energy.escaped[0] / energy.emitted[0], 1, 0.005);  // a flat lamp lights nothing but the ends
}

TEST(Hierarchy, HasAFractionOfTheLinks) {
  const Room room = furnished(8, 0.05);
  const auto reference = solve(room, kCeilingLamp, {.rays = 64, .seed = 1, .hierarchy = false});
  const auto coarse = solve(room, kCeilingLamp, {.error = 1e-4}), fine = solve(room, kCeilingLamp, {.error = 3e-5}),
             full = solve(room, kCeilingLamp, {.hierarchy = false});
  EXPECT_LT(difference(coarse, reference), 0.04);
  EXPECT_LT(difference(fine, reference), 0.02);
  EXPECT_LT(difference(full, reference), 0.002);
  EXPECT_GT(static_cast<double>(full.statistics.links), 0.95 * static_cast<double>(full.statistics.all_pairs));
  EXPECT_LT(12 * coarse.statistics.links, full.statistics.links);
  EXPECT_LT(6 * fine.statistics.links, full.statistics.links);
}

// Where the light is even enough for a hierarchy to pay: at one percent, at least ten times fewer links. Without a
// hierarchy there are as many as pairs, but for some 3% that are proved to have no light between them.
TEST(Hierarchy, HasATenthOfTheLinksAtOnePercent) {
  const Room room = furnished(11, 0.05);
  const auto reference = solve(room, kCeilingLamp, {.rays = 32, .seed = 1, .hierarchy = false});
  const auto result = solve(room, kCeilingLamp, {.error = 6e-6, .rays = 8});
  EXPECT_LT(difference(result, reference), 0.01);
  EXPECT_LT(10 * result.statistics.links, 0.95 * static_cast<double>(result.statistics.all_pairs));
  const RadiosityStatistics &ours = result.statistics, &all = reference.statistics;  // docs/guide/form_factors.md
  std::cout << difference(result, reference) << " by " << ours.links << " links, " << ours.rays << " rays, "
            << to_ms(ours.board_time) << " ms; all: " << all.links << ", " << all.rays / 4 << ", "
            << to_ms(all.board_time) / 4 << "\n";
}

TEST(Radiosity, IsTheSameBitsWhoeverMakesTheRays) {
  const auto by_board = solve(furnished(6, 0.1), kCeilingLamp, {.error = 1e-4});
  const auto by_host = solve(furnished(6, 0.1), kCeilingLamp, {.error = 1e-4, .made = PairRays::kByHost});
  EXPECT_EQ(by_board.outgoing, by_host.outgoing);
  EXPECT_GT(by_host.statistics.bus_up_bytes, by_board.statistics.bus_up_bytes);
}

TEST(Radiosity, StandardErrorsAreOfTheSizeOfTheErrors) {
  const RadiositySettings settings{.rays = 8, .max_rays = 8, .hierarchy = false, .balance = false};
  auto other = settings;
  other.seed = 1;
  const auto a = solve(furnished(6, 0.1), kCeilingLamp, settings), b = solve(furnished(6, 0.1), kCeilingLamp, other);
  double squares = 0, expected = 0;
  for (std::size_t i = 0; i < a.leaves.size(); ++i) {
    double off = 0;
    for (std::size_t c = 0; c < 3; ++c) off += a.incident[i][c] - b.incident[i][c];
    squares += off * off;
    expected += a.standard_error[i] * a.standard_error[i] + b.standard_error[i] * b.standard_error[i];
  }
  EXPECT_LT(squares, 2 * expected);
  EXPECT_GT(squares, 0.02 * expected);
}

TEST(Radiosity, WhatIsWrongIsNamed) {
  Board board = Board::open(kUri);
  const SceneSetup setup = reference::setup_of({.size = 4});
  const auto expect = [&](const Emissions& emissions, const RadiositySettings& settings, const char* text) {
    EXPECT_THROWS(InputError, text, solve_radiosity(board, setup, emissions, settings));
  };
  expect({}, {}, "emissions: expected some power from an open face or medium, got none");
  expect({{{0, -1, 0}}}, {}, "emissions[0].surface: expected numbers from 0, got -1");
  expect(kWalls, {.error = 0}, "settings.error: expected a number above 0, got 0");
  expect(kWalls, {.rays = 4}, "settings.rays: expected 8 to 65536, got 4");
  expect(kWalls, {.leaf_voxels = 3}, "settings.leaf_voxels: expected a power of two, got 3");
}

}  // namespace
TEST(Radiosity, OfAVolumeThatTheCardDoesNotStoreHasTheSameLight) {
  const std::string blocks = "emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=";
  Board whole = Board::open(blocks + "64"), small = Board::open(blocks + "32");
  const SceneSetup setup = reference::setup_of({.size = 38});  // 40 with walls: 125 blocks, of which one card stores 64
  const auto expected = solve_radiosity(whole, setup, kWalls, {}), got = solve_radiosity(small, setup, kWalls, {});
  EXPECT_EQ(got.statistics.energy.absorbed_by_faces, expected.statistics.energy.absorbed_by_faces);
  EXPECT_GT(expected.statistics.energy.absorbed_by_faces[0], 0);
}

}  // namespace gicube::samples
