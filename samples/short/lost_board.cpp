// A lost board: its process ends between two pictures, and the program continues with a new one.
//
// Usually another program, such as systemd, starts the process of a shared board. Here the program starts it on a
// socket, kills it, and starts another one. After Board::reopen() the new board has tables and volume again
// (OpenOptions::keep_volume).
//
//   c++ -std=c++20 -O2 lost_board.cpp $(pkg-config --cflags --libs gicube) -o lost_board
//   ./lost_board
//
// Runs the gicube-board of the environment variable GICUBE_BOARD, or of the PATH. Prints the events. Returns 1 unless
// the board is lost once and all pictures have the same bits as those of another board.
#include <gicube/board.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>

#include "voxels.h"

constexpr int kEdge = 48, kPictures = 4;

pid_t start_board(std::string address) {
  std::string words[] = {"gicube-board", "--quiet", "--listen", std::move(address)};
  if (const char* program = std::getenv("GICUBE_BOARD")) words[0] = program;
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  pid_t process = -1;
  const int error = ::posix_spawnp(&process, arguments[0], nullptr, nullptr, arguments, environ);
  if (error != 0) throw std::system_error(error, std::generic_category(), arguments[0]);
  return process;
}

void end_board(pid_t process) {
  ::kill(process, SIGKILL);
  ::waitpid(process, nullptr, 0);
}

// Calls `open` until there is a board, for at most ten seconds, because a process needs some time to start.
template <typename Open>
auto when_ready(const Open& open) {
  for (int attempt = 0;; ++attempt) {
    try {
      return open();
    } catch (const gicube::OpenFailed&) {
      if (attempt == 200) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

gicube::Image picture(gicube::Board& board, int number) {
  gicube::View view;
  view.eye = {120.0 - 40 * number, 90, -70};
  view.look_at = {23.5, 23.5, 23.5};
  view.width = view.height = 96;
  return board.render(view);
}

void load(gicube::Board& board) {
  const std::vector<std::byte> voxels = make_ball(kEdge, 18);
  board.load_volume({.samples = voxels, .dims = {kEdge, kEdge, kEdge}});
  board.set_transfer_function({.colours = {{0, {0.4, 0.8, 1}}}, .opacities = {{96, 0}, {160, 0.4}}});
}

int main() {
  const auto socket = std::filesystem::temp_directory_path() / ("lost_board." + std::to_string(::getpid()));
  const std::string address = "unix:" + socket.string();
  pid_t process = start_board(address);
  auto board = when_ready([&] { return gicube::Board::open(address, {.keep_volume = true}); });
  load(board);

  auto other = gicube::Board::open("emu:");  // is not lost
  load(other);
  int losses = 0, different = 0;
  for (int number = 0; number < kPictures; ++number) {
    if (number == 2) end_board(process);
    gicube::Image image;
    try {
      image = picture(board, number);
    } catch (const gicube::DeviceLost& lost) {
      ++losses;
      std::printf("picture %d: %s\n", number, lost.what());
      process = start_board(address);
      const gicube::Reopened found = when_ready([&] { return board.reopen(); });
      std::printf("a %s, %s\n", found.resumed ? "board with the same session" : "new board",
                  found.volume ? "with the volume" : "which has no volume");
      image = picture(board, number);
    }
    different += image != picture(other, number);
  }
  end_board(process);
  std::filesystem::remove(socket);  // a killed board leaves it
  std::printf("%d pictures; the board was lost %d times; %d pictures have other bits\n", kPictures, losses, different);
  return losses != 1 || different != 0;
}
