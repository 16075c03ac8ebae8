// Random volumes and views for the tests of volumes that the card does not store whole, and a pair of boards: one that
// stores them in bricks, and one that stores them whole.
#pragma once

#include <array>
#include <random>
#include <string>
#include <vector>

#include "test_board.h"

namespace gicube::reference {

struct Blobs {
  Dims dims;
  std::vector<std::byte> samples;

  VolumeView view() const { return {.samples = samples, .type = SampleType::kUint8, .dims = dims}; }
};

// Soft balls in a fog that does not fill all blocks; edges of `least` to `most` voxels.
Blobs make_blobs(std::mt19937& random, int least, int most);

View make_view(std::mt19937& random, const Dims& dims, int pixels);

TransferFunction fog_and_balls(double fog);

// From point to point of the volume, each with an energy of 3: segments, or rays that go on.
std::vector<HostRay> random_rays(std::mt19937& random, const Dims& dims, std::uint32_t count, bool segments = false);
Light make_light(std::mt19937& random, const Dims& dims);
Material make_material(std::mt19937& random);
Illumination make_illumination(std::mt19937& random, std::uint32_t seed);

void expect_same_accounts(const LightingReport& got, const LightingReport& expected);

// `card`, `endless`: asic.max_volume_voxels.
struct BrickBoards {
  Board small, large;

  BrickBoards(const std::string& base, const std::string& card, const std::string& endless = "128",
              const OpenOptions& options = {})
      : small(Board::open(base + "&set=asic.max_volume_voxels=" + card, options)),
        large(Board::open(base + "&set=asic.max_volume_voxels=" + endless)) {}
  std::array<Board*, 2> both() { return {&small, &large}; }
};

}  // namespace gicube::reference
