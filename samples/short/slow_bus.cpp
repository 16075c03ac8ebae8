// A test of an application on a slow bus, for the oldest machine of its users (gicube/testing.h).
//
// The application shows a preview in a quarter of the size while the user turns the object; the picture must be on the
// host within 16 ms. Times are simulated, so the test has the same result on all machines at any load.
//
//   c++ -std=c++20 -O2 slow_bus.cpp $(pkg-config --cflags --libs gicube) -o slow_bus
//   ./slow_bus
//
// With CMake, gicube_add_test(NAME slow_bus SOURCES slow_bus.cpp BUS pci33 agp4x) makes a test for each bus. Returns 1
// and prints the expected and the actual value, if the picture is late or the time of its transfer differs from the
// closed form.
#include <gicube/testing.h>

#include <cstdio>

#include "voxels.h"

namespace test = gicube::test;

constexpr int kEdge = 64, kWidth = 1024, kHeight = 1024;

// ---- the application

void load(gicube::Board& board) {
  const std::vector<std::byte> voxels = make_ball(kEdge, 26);
  board.load_volume({.samples = voxels, .dims = {kEdge, kEdge, kEdge}});
  board.set_transfer_function({.colours = {{0, {1, 0.9, 0.6}}}, .opacities = {{96, 0}, {160, 0.4}}});
}

gicube::Image show(gicube::Board& board, bool preview) {
  gicube::View view;
  view.eye = {160, 120, -100};
  view.look_at = {31.5, 31.5, 31.5};
  view.width = preview ? kWidth / 4 : kWidth;
  view.height = preview ? kHeight / 4 : kHeight;
  board.render_to_framebuffer(view);
  return board.read_framebuffer();
}

// ---- its test

void check(const char* bus, double clock) {
  gicube::Board board = test::BoardSetup{.bus = bus}.open();
  load(board);
  const test::Window turning(board);
  show(board, true);
  const test::Measured preview = turning.end();
  const test::Window resting(board);
  show(board, false);
  const test::Measured whole = resting.end();
  std::printf("%s: %.2f ms per preview, %.2f ms per full picture\n", bus, gicube::to_ms(preview.time),
              gicube::to_ms(whole.time));

  test::require({gicube::to_ms(preview.time) < 16, "a preview takes too long"});
  // A pixel has 36 bits. Bursts of 256 dwords take 259 clocks.
  constexpr double kBytes = kWidth * kHeight * 4.5;
  test::require(counter_is(whole, "bus.image.bytes", kBytes));
  test::require(test::near("picoseconds of the picture on the bus", double(whole.counters.value("bus.image.time_ps")),
                           kBytes / 4 / 256 * 259 * clock, 0.001));
}

int main() {
  try {
    check("pci33", 30e3);  // picoseconds
    check("agp4x", 15e3);
  } catch (const test::Failed& failed) {
    std::printf("%s\n", failed.what());
    return 1;
  }
}
