// depth_map FILE.pgm [BOARD]: a depth map of a ball, by an emulated board unless another one is named.
#include <cstdio>
#include <fstream>

#include "depth_map.h"

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: depth_map FILE.pgm [BOARD]\n");
    return 2;
  }
  constexpr int kEdge = 64, kSize = 256;
  try {
    auto board = gicube::Board::open(argc == 3 ? argv[2] : "emu:");
    example::load(board, example::ball(kEdge, 24), kEdge);
    const gicube::Picoseconds begin = board.now();
    const example::DepthMap map = example::depth_map(board, kEdge, kSize, kSize, 4);
    std::printf("%d rays in %.3f simulated ms\n", kSize * kSize, gicube::to_ms(board.now() - begin));

    std::ofstream file(argv[1], std::ios::binary);
    file << "P5\n" << map.width << ' ' << map.height << "\n255\n";
    for (const float depth : map.depths) file << static_cast<char>(depth < 0 ? 0 : 255 - 3 * depth);
    if (!file.flush()) {
      std::fprintf(stderr, "depth_map: cannot write %s\n", argv[1]);
      return 1;
    }
  } catch (const gicube::Error& error) {
    std::fprintf(stderr, "depth_map: %s\n", error.what());
    return 1;
  }
}
