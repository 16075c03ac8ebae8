#include "test_board.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "temporary_directory.h"
#include "voxels.h"

namespace gicube {

// A script that says its id and becomes the board stands in for it.
BoardProcess open_board_process(const OpenOptions& options) {
  const reference::TemporaryDirectory folder;
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
  for_each_voxel({size, size, size}, [&](int x, int y, int z) {
    samples.push_back(inside(x) && inside(y) && inside(z) ? std::byte{200} : std::byte{0});
  });
}

VolumeView BoxVolume::view() const {
  return {.samples = samples, .type = SampleType::kUint8, .dims = {size, size, size}};
}

TransferFunction step_function(double opacity) {
  return {.colours = {{0, {1, 0.5, 0.25}}}, .opacities = {{100, 0}, {100, opacity}}};
}

void load_box(Board& board, double opacity) {
  board.load_volume(BoxVolume(32, 8, 23).view());
  board.set_transfer_function(step_function(opacity));
}

BoardProcess stopped_board(const OpenOptions& options) {
  BoardProcess process = open_board_process(options);
  load_box(process.board);
  process.board.counters();  // it has taken all that was sent
  ::kill(process.id, SIGSTOP);
  return process;
}

Board box_board(double opacity, const OpenOptions& options) {
  Board board = Board::open(kSmallBlocks, options);
  load_box(board, opacity);
  return board;
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

std::vector<HostRay> front_rays(std::uint32_t count) {
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < count; ++i) {
    rays.push_back({.id = i, .position = {i % 31 + 0.25, i / 31 % 31 + 0.25, 0}, .direction = {0, 0, 1}});
  }
  return rays;
}

}  // namespace gicube
