#include "test_board.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "temporary_directory.h"

namespace gicube::reference {

Board open_board(const std::string& uri, const OpenOptions& options) {
  ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  return Board::open(uri, options);
}

// A script that says its id and becomes the board stands in for it.
BoardProcess open_board_process(const OpenOptions& options) {
  const TemporaryDirectory folder;
  const std::string script = folder.file("board"), id_file = folder.file("id");
  std::ofstream(script) << "#!/bin/sh\necho $$ > " << id_file << "\nexec " GICUBE_BIN_DIR "/gicube-board \"$@\"\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  ::setenv("GICUBE_BOARD", script.c_str(), 1);
  BoardProcess opened{Board::open(kSmallBlocks, options), 0};
  ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  std::ifstream(id_file) >> opened.id;
  if (opened.id <= 0) throw std::runtime_error("the board did not say its process");
  return opened;
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
