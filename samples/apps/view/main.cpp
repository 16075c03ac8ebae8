// gicube-view: volumes and scenes in the browser, and the board that makes their pictures.
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

#include "gicube/access.h"
#include "scene/common/whole_file.h"
#include "scene/program/program.h"
#include "view/folder.h"
#include "view/options.h"
#include "view/server.h"

extern char** environ;  // POSIX has it in no header

namespace {

using namespace gicube::samples;
using namespace gicube::samples::view;

constexpr std::chrono::milliseconds kMaxEnding{900};  // chosen: as that of gicube-board

bool has_desktop() { return std::getenv("DISPLAY") != nullptr || std::getenv("WAYLAND_DISPLAY") != nullptr; }

// Opens the browser by xdg-open, which prints its own errors. Its argument is a page that redirects to the address: the
// address has the token, and all users can see command lines.
void open_browser(const std::string& address, const std::filesystem::path& folder) {
  const std::filesystem::path page = folder / ".open.html";
  gicube::scene::write_whole(page,
                             "<!doctype html>\n<meta http-equiv=\"refresh\" content=\"0; url=" + address + "\">\n");
  std::string program = "xdg-open", name = page.string();
  char* const argv[] = {program.data(), name.data(), nullptr};
  sigset_t piped;
  ::sigemptyset(&piped);
  ::sigaddset(&piped, SIGPIPE);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setsigdefault(&attributes, &piped);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = -1;
  if (::posix_spawnp(&child, program.c_str(), nullptr, &attributes, argv, environ) != 0)
    fmt::print(stderr, "gicube-view: xdg-open is not installed: open the address in a browser\n");
  ::posix_spawnattr_destroy(&attributes);
}

int run(int argc, char** argv) {
  auto options = view::parse_options(argc, argv, std::cout);
  if (!options) return 0;
  ::signal(SIGPIPE, SIG_IGN);  // the reader of standard output may be gone
  const PrivateFolder folder;
  PostedFiles files(folder.path());
  options->view.folder = folder.path();
  options->view.files = &files;
  Viewer* viewer = nullptr;
  Server server(
      {.come = [&viewer](Page page) { viewer->come(page); },
       .leave = [&viewer](Page page) { viewer->leave(page); },
       .ask = [&viewer](Page page, Request request) { viewer->ask(page, std::move(request)); },
       .download = [&viewer](const std::string& what, std::uint64_t number) { return viewer->download(what, number); },
       .files = &files},
      options->listen, gicube::new_token());
  Viewer own(options->view, [&server](Page page, const Packet& packet) { server.send(page, packet); });
  viewer = &own;
  fmt::print("{}\n", server.address());
  std::fflush(stdout);
  if (options->open.value_or(has_desktop() && ::isatty(STDOUT_FILENO) == 1))
    open_browser(server.address(), folder.path());
  server.run();
  if (!own.end(kMaxEnding)) {  // abort what is still running
    folder.remove();
    ::_exit(0);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-view", [&] { return run(argc, argv); });
}
