// gicube-view: volumes and scenes in the browser, and the board that makes their pictures.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

#include "gicube/access.h"
#include "scene/program/program.h"
#include "view/folder.h"
#include "view/options.h"
#include "view/server.h"

extern char** environ;  // POSIX has it in no header

namespace {

using namespace gicube::samples;
using namespace gicube::samples::view;

bool has_desktop() { return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }

// By xdg-open, which says by itself what is wrong; the address is printed anyway.
void open_browser(std::string address) {
  std::string program = "xdg-open";
  char* const argv[] = {program.data(), address.data(), nullptr};
  pid_t child = -1;
  if (::posix_spawnp(&child, program.c_str(), nullptr, nullptr, argv, environ) != 0)
    fmt::print(stderr, "gicube-view: no xdg-open here: open the address in a browser\n");
}

int run(int argc, char** argv) {
  auto options = view::parse_options(argc, argv, std::cout);
  if (!options) return 0;
  const PrivateFolder folder;
  options->view.folder = folder.path();
  Viewer* viewer = nullptr;
  Server server(
      {.come = [&viewer](Page page) { viewer->come(page); },
       .leave = [&viewer](Page page) { viewer->leave(page); },
       .ask = [&viewer](Page page, Request request) { viewer->ask(page, std::move(request)); },
       .download = [&viewer](const std::string& what, std::uint64_t number) { return viewer->download(what, number); },
       .folder = folder.path()},
      options->listen, gicube::new_token());
  Viewer own(options->view, [&server](Page page, const Packet& packet) { server.send(page, packet); });
  viewer = &own;
  fmt::print("{}\n", server.address());
  std::fflush(stdout);
  if (options->open.value_or(has_desktop() && ::isatty(STDOUT_FILENO) == 1)) open_browser(server.address());
  server.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-view", [&] { return run(argc, argv); });
}
