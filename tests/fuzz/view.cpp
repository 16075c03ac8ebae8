// What reaches gicube-view from outside: bytes of a connection, and messages of a page.
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "gicube/error.h"
#include "targets.h"
#include "temporary_directory.h"
#include "view/server.h"
#include "view/settings.h"

namespace gicube::fuzz {
namespace {

namespace view = samples::view;

const std::string kToken = "0123456789abcdef";

}  // namespace

// A connection's bytes; they end as if the other side had closed its half.
void view_http(Bytes input) {
  static const reference::TemporaryDirectory folder;
  bool came = false;
  view::Pages pages;
  pages.come = [&came](view::Page) { came = true; };
  pages.leave = [](view::Page) {};
  pages.ask = [](view::Page, const view::Request&) {};
  pages.download = [](const std::string&, std::uint64_t) { return std::optional<view::Viewer::Download>(); };
  view::PostedFiles files(folder.path());
  pages.files = &files;
  view::Server server(pages, kToken);
  int ends[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return;
  std::size_t sent = 0;
  while (sent < input.size()) {
    const ssize_t count = ::send(ends[0], input.data() + sent, input.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count <= 0) break;
    sent += static_cast<std::size_t>(count);
  }
  ::shutdown(ends[0], SHUT_WR);
  std::string answer;
  // Many requests have more answers than a socket holds.
  std::thread reader([&answer, end = ends[0]] {
    std::string part(std::size_t{1} << 16, '\0');
    for (ssize_t count = 1; count > 0;) {
      count = ::recv(end, part.data(), part.size(), 0);
      if (count > 0) answer.append(part, 0, static_cast<std::size_t>(count));
    }
  });
  server.serve(ends[1]);
  server.run();
  reader.join();
  ::close(ends[0]);
  expect(server.connections() == 0, "a connection whose other side has gone ends");
  expect(answer.empty() || answer.starts_with("HTTP/1.1 "), "an answer is HTTP");
  const bool has_token = text_of(input).find('%') != std::string_view::npos ||
                         text_of(input).find(kToken) != std::string_view::npos;  // % may stand for any of its letters
  expect(!came || has_token, "no page comes without the token");
  for (const auto& entry : std::filesystem::directory_iterator(folder.file(".new"))) {
    expect(view::is_file_name(entry.path().filename().string()), "a posted file has a plain name");
    std::filesystem::remove_all(entry.path());
  }
}

void view_message(Bytes input) {
  static const reference::TemporaryDirectory folder;  // of transfer functions
  try {
    const view::Request request = view::parse_request(text_of(input));
    for (const std::string& name : request.names) expect(view::is_file_name(name), "a posted file's name");
    view::Shelf shelf;
    shelf.inputs = {{"ball", "builtin:buckyball"}};
    shelf.folder = folder.path();
    const samples::RenderOptions options = view::options_of(request.settings, shelf, {});
    expect(options.input == "builtin:buckyball", "no other input than one of the shelf");
    expect(options.output == samples::RenderOptions().output && options.board.stats.empty(), "nothing is written");
    expect(options.board.board == "emu:" && options.board.config.empty(), "no other board, no other file");
    expect(!view::command_of(request.settings, shelf, {}).empty(), "it has a command");
  } catch (const samples::UsageError&) {
  } catch (const Error&) {
  }
}

}  // namespace gicube::fuzz
