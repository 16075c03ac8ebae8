// Two boards that share work (BoardGroup): each renders half of a picture's rows and traces half of the rays.
//
// Both load the volume. Their common results have the same bits as one board's, so the pictures of one and two boards
// can be compared exactly.
//
//   c++ -std=c++20 -O2 two_boards.cpp $(pkg-config --cflags --libs gicube) -o two_boards
//   ./two_boards
//
// Prints the simulated time of a picture on one board and on two, with one bus and with two. Returns 1 unless all
// pictures have the same bits and two boards with two buses need less than 0.6 times the time of one.
#include <gicube/board_group.h>

#include <cstdio>

#include "voxels.h"

constexpr int kEdge = 64;

struct Result {
  gicube::Image image;
  std::vector<gicube::TracedRay> rays;
  double ms = 0;  // simulated, of the picture
};

Result run(const char* address) {
  const std::vector<std::byte> voxels = make_ball(kEdge, 26);
  auto boards = gicube::BoardGroup::open(address);
  boards.on_all([&](gicube::Board& board) {
    board.load_volume({.samples = voxels, .dims = {kEdge, kEdge, kEdge}});
    board.set_transfer_function({.colours = {{0, {0.8, 1, 0.6}}}, .opacities = {{96, 0}, {160, 0.3}}});
  });
  gicube::View view;
  view.eye = {160, 120, -100};
  view.look_at = {31.5, 31.5, 31.5};
  view.width = view.height = 160;
  Result result;
  const gicube::Picoseconds begin = boards.now();
  result.image = boards.render(view);
  result.ms = gicube::to_ms(boards.now() - begin);
  std::vector<gicube::HostRay> rays;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    rays.push_back({i, {double(i % 60) + 1, double(i / 60 % 60) + 1, 0}, {0, 0, 1}});
  }
  result.rays = boards.trace(rays, {.type = gicube::RayType::kFirstHit, .opacity = 0.5}).rays;
  std::printf("%-40s %.3f ms per picture\n", address, result.ms);
  return result;
}

int main() {
  const Result one = run("emu:?fidelity=cycle"), shared = run("emu:?fidelity=cycle&boards=2&buses=shared"),
               own = run("emu:?fidelity=cycle&boards=2&buses=own");
  bool same = true;
  for (const Result& two : {shared, own}) same = same && two.image == one.image && two.rays == one.rays;
  std::printf("pictures and rays have %s bits\n", same ? "the same" : "other");
  return !same || own.ms > 0.6 * one.ms;
}
