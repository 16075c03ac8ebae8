// A client that works until it is killed: gicube-victim PATH. It says "working" once the board is its own.
#include <cstdio>
#include <exception>

#include "good_client.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    gicube::Board board = gicube::Board::open(std::string("unix:") + argv[1]);
    std::puts("working");
    std::fflush(stdout);
    gicube::system_test::prepare(board);
    for (;;) gicube::system_test::work(board);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gicube-victim: %s\n", error.what());
    return 1;
  }
}
