// gicube-replay: plays a captured session (docs/guide/capture.md) to a board and compares the answers.
//
// Exit codes: 0 the same, 1 a difference or a failure, 2 wrong usage.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <exception>
#include <memory>
#include <string>

#include "capture_reader.h"
#include "gicube/error.h"
#include "gicube/unknown_options.h"
#include "gicube/whole_file.h"
#include "player.h"
#include "transport/connect.h"
#include "transport/launch.h"
#include "transport/pci_function.h"
#include "transport/uri.h"

namespace {

using namespace gicube;
using namespace gicube::replay;

void print(const Report& report) {
  fmt::print("sent {} frames with {} bytes, compared {} answers\n", report.sent_frames, report.sent_bytes,
             report.compared);
  fmt::print("{}\n", report.same_machine
                         ? "the board's configuration is that of the capture: times and counters are compared too"
                         : "the board has another configuration: times and counters are not compared");
  if (!report.complete) fmt::print("note: the capture has no end: its process died\n");
  if (report.missing > 0) fmt::print("{} answers of the capture are missing\n", report.missing);
  if (report.differences == 0) {
    if (report.missing == 0) fmt::print("no difference\n");
    return;
  }
  fmt::print("{} differences; the first: {}\n", report.differences, report.first_difference);
}

int run(const std::string& file, const std::string& board, std::uint32_t watchdog_ms) {
  const Uri uri = parse_uri(board);
  const std::chrono::milliseconds watchdog(watchdog_ms);
  std::unique_ptr<ChildProcess> child;
  std::unique_ptr<PciFunction> function;
  Fd socket;
  std::string token;
  std::shared_ptr<Tls> tls;
  if (uri.scheme == UriScheme::kEmu) {
    child = std::make_unique<ChildProcess>(find_board_program(), uri.board_arguments);
    socket = child->take_socket();
  } else if (uri.scheme == UriScheme::kPci) {
    function = std::make_unique<PciFunction>(uri.path);
    socket = function->take_socket();
  } else {
    socket = connect(uri, watchdog);
    if (uri.scheme == UriScheme::kTcp) token = access_token(socket.get(), uri.is_secure, {});
    if (uri.is_secure) tls = make_tls(uri.host, {});
  }
  const Report report = play(file, std::move(socket), watchdog, {token, tls});
  print(report);
  return report.good() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::string file, board = "emu:";
  std::uint32_t watchdog_ms = 600'000;
  CLI::App app("Sends the host's frames of a captured session to a board, and reports where its answers differ.",
               "gicube-replay");
  app.set_version_flag("--version", "gicube-replay " GICUBE_VERSION);
  app.add_option("capture", file,
                 "written by OpenOptions::capture, emu:?capture=FILE or GICUBE_CAPTURE; may be gzipped")
      ->type_name("FILE")
      ->required();
  app.add_option("--board", board, "the board, as Board::open() takes it")->type_name("URI")->capture_default_str();
  app.add_option("--watchdog", watchdog_ms, "time limit for an answer; 0 = none")->type_name("MS");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "gicube-replay: {}\n", usage_fault(app, error.what()));
    return 2;
  }
  try {
    const int code = run(file, board, watchdog_ms);
    check_standard_output();
    return code;
  } catch (const BadArgument& error) {
    fmt::print(stderr, "gicube-replay: --board: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-replay: {}\n", error.what());
    return 1;
  }
}
