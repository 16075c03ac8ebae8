// turntable SCAN FILE.png [SECONDS [BOARD]]: a picture of a scan on a turntable, by an emulated board unless another
// one is named.
#include <gicube/scene/image_file.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "turntable.h"

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: turntable SCAN FILE.png [SECONDS [BOARD]]\n");
    return 2;
  }
  try {
    gicube::Board board = gicube::Board::open(argc == 5 ? argv[4] : "emu:");
    const double seconds = argc > 3 ? std::atof(argv[3]) : 0;
    const gicube::Image image = example::picture(board, example::turntable(argv[1]), seconds);
    if (const std::string why = board.why_invisible(image); !why.empty())
      std::fprintf(stderr, "turntable: warning: %s\n", why.c_str());
    gicube::scene::write_png(image, argv[2], gicube::Colour{0.1, 0.1, 0.12});
    std::printf("%s: %.3f simulated ms\n", argv[2], gicube::to_ms(board.now()));
  } catch (const gicube::scene::InputError& error) {
    for (const gicube::scene::Fault& fault : error.faults())
      std::fprintf(stderr, "turntable: %s\n", fault.text.c_str());
    return 1;
  } catch (const gicube::Error& error) {
    std::fprintf(stderr, "turntable: %s\n", error.what());
    return 1;
  }
}
