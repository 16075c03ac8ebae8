// The application against boards of a known bus, without a test framework: what does not hold is thrown.
#include <gicube/testing.h>

#include <cmath>
#include <cstdio>

#include "depth_map.h"

namespace {

using namespace gicube::test;

constexpr int kEdge = 48, kWidth = 512, kHeight = 32;
constexpr double kRadius = 16;

// The first opaque sample lies up to a step, a quarter of a voxel, behind the surface, and grey levels are rounded.
void check_depths(const example::DepthMap& map) {
  const double middle = (kEdge - 1) / 2.0;
  int hits = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int x = 0; x < kWidth; ++x) {
      const double dx = (x + 0.5) / kWidth * (kEdge - 1) - middle, dy = (row + 0.5) / kHeight * (kEdge - 1) - middle;
      const double inside = kRadius * kRadius - dx * dx - dy * dy;
      const double depth = map.depths[static_cast<std::size_t>(row * kWidth + x)];
      if (inside > 20) {
        const double behind = depth - (middle - std::sqrt(inside));
        require({behind > -0.1 && behind < 0.35, "a depth is not the ball's: off by " + std::to_string(behind)});
        ++hits;
      } else if (inside < -20) {
        require({depth < 0, "a surface where there is none"});
      }
    }
  }
  require({hits > 1000, "the ball was not hit"});
}

}  // namespace

int main() {
  const BoardSetup setup = BoardSetup::from_environment();
  gicube::Board board = setup.open();
  example::load(board, example::ball(kEdge, kRadius), kEdge);

  const Window one_by_one(board);
  check_depths(example::depth_map(board, kEdge, kWidth, kHeight, 1));
  const Measured waiting = one_by_one.end();
  require(counter_is(waiting, "bus.up.bytes", 32.0 * kWidth * kHeight));

  const Window streamed(board);
  check_depths(example::depth_map(board, kEdge, kWidth, kHeight, 4));
  const Measured flowing = streamed.end();

  // A row: 4096 dwords each way. One by one it comes down in bursts of 256 dwords (PCI: 259 clocks of 30 ns) or 64
  // (AGP 2x: 34 of 15 ns), passes the DSP in 80 ns per ray and 70 ns to begin, and goes up in bursts of 256 (259
  // clocks).
  const double dsp = 70e3 + 80e3 * kWidth;
  const double row = setup.bus == "agp2x" ? 64 * 34 * 15e3 + dsp + 16 * 259 * 15e3 : 2 * 16 * 259 * 30e3 + dsp;
  require(time_is(waiting, row * kHeight, 0.01));
  require({flowing.time < waiting.time, "batches in flight are no faster than one by one"});
  std::printf("%s: %.3f ms a frame, %.3f one by one\n", setup.bus.c_str(), gicube::to_ms(flowing.time),
              gicube::to_ms(waiting.time));
}
