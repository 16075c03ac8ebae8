#include "test_board.h"

#include <cstdlib>

namespace gicube::reference {

Board open_board(const std::string& uri) {
  ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  return Board::open(uri);
}

BoxVolume::BoxVolume(int edge, int first, int last) : size(edge), low(first), high(last) {
  const auto inside = [this](int i) { return i >= low && i <= high; };
  for (int z = 0; z < size; ++z) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        samples.push_back(inside(x) && inside(y) && inside(z) ? std::byte{200} : std::byte{0});
      }
    }
  }
}

VolumeView BoxVolume::view() const {
  return {.samples = samples, .type = SampleType::kUint8, .dims = {size, size, size}};
}

TransferFunction step_function(double opacity) {
  return {.colours = {{0, {1, 0.5, 0.25}}}, .opacities = {{100, 0}, {100, opacity}}};
}

View front_view(int size) {
  const double middle = (size - 1) / 2.0;
  View view;
  view.look_at = {middle, middle, middle};
  view.eye = {middle, middle, -100};
  view.orthographic_height = size;
  view.width = 32;
  view.height = 32;
  view.shade = false;
  return view;
}

}  // namespace gicube::reference
