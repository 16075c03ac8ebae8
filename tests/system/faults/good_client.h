// An application that uses the board as it should: what it gets is known, bit for bit and picosecond for picosecond.
#pragma once

#include <gicube/board.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace gicube::system_test {

inline constexpr int kEdge = 24;  // of the volume, voxels

// What a board configuration flag makes of the blocks, so that this volume has 3^3 of them.
std::vector<std::string> small_board();

// A ball with a gradient inside, so that every ray through it has a value of its own.
class GoodVolume {
 public:
  GoodVolume();
  VolumeView view() const { return {.samples = samples_, .type = SampleType::kUint8, .dims = {kEdge, kEdge, kEdge}}; }

 private:
  std::vector<std::byte> samples_;
};

TransferFunction good_function();
View good_view(int turn);

// Ray `number` of all: the same for the same number.
HostRay good_ray(std::uint64_t number);
std::vector<HostRay> good_rays(std::uint64_t first, std::size_t count);

// Loads the volume and sets the transfer function.
void prepare(Board& board);

// Everything that one round of work shows: pictures, rays, times.
struct Round {
  std::vector<Image> pictures;
  std::vector<RayBatch> batches;
  Picoseconds begin = 0, end = 0;

  friend bool operator==(const Round& a, const Round& b);
};

// Renders, submits and receives on a prepared board.
Round work(Board& board);

}  // namespace gicube::system_test
