// A volume from disk that is never completely in memory: VolumeStream reads planes during loading.
//
// The driver requests a few planes at a time, in order, and keeps data that the card does not store in its own file. So
// a volume may be larger than the host's memory; its edges have up to 1024 voxels.
//
//   c++ -std=c++20 -O2 stream_from_disk.cpp $(pkg-config --cflags --libs gicube) -o stream_from_disk
//   ./stream_from_disk
//
// Writes a raw file and removes it again. Prints the greatest number of planes per read. Returns 1 if that is at least
// half of them, if a plane is not read exactly once, or if the picture differs from that of the same volume in memory.
#include <gicube/board.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "voxels.h"

constexpr int kEdge = 160;

gicube::Image picture(gicube::Board& board) {
  board.set_transfer_function({.colours = {{0, {1, 0.7, 0.4}}}, .opacities = {{96, 0}, {160, 0.3}}});
  gicube::View view;
  view.eye = {400, 300, -250};
  view.look_at = {79.5, 79.5, 79.5};
  view.width = view.height = 128;
  return board.render(view);
}

int main() {
  const std::vector<std::byte> voxels = make_ball(kEdge, 70);
  const auto file = std::filesystem::temp_directory_path() / "stream_from_disk.raw";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(voxels.data()), static_cast<std::streamsize>(voxels.size()));

  int next = 0, most = 0;
  bool in_order = true;
  std::ifstream in(file, std::ios::binary);
  const auto read = [&](int first, int planes, std::span<std::byte> out) {
    in_order = in_order && first == next;
    next = first + planes;
    most = std::max(most, planes);
    in.seekg(std::streamoff{first} * kEdge * kEdge);
    if (!in.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()))) {
      throw std::runtime_error("the file was cut short");  // leaves load_volume(), and the board keeps its volume
    }
  };
  auto board = gicube::Board::open("emu:");
  board.load_volume(gicube::VolumeStream{.read = read, .dims = {kEdge, kEdge, kEdge}});
  std::printf("at most %d of %d planes at once\n", most, kEdge);
  in.close();
  std::filesystem::remove(file);

  auto other = gicube::Board::open("emu:");
  other.load_volume({.samples = voxels, .dims = {kEdge, kEdge, kEdge}});
  const bool same = picture(board) == picture(other);
  std::printf("the picture has %s bits of the volume in memory\n", same ? "the" : "not the");
  return !same || !in_order || next != kEdge || 2 * most >= kEdge;
}
