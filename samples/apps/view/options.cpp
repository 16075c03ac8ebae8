#include "view/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "scene/common/checks.h"
#include "scene/program/option_group.h"

#include <boost/asio/ip/address.hpp>

namespace gicube::samples::view {
namespace {

const char* const kFooter =
    "The printed address has a token, which is required for access. Ctrl-C ends the program.\n"
    "Exit codes: 0 ended, 1 failed, 2 wrong usage.";

// `text`: --listen.
void read_listen(const std::string& text, Listen& listen) {
  const bool has_key = listen.certificate_file.empty();
  if (has_key != listen.key_file.empty())
    throw UsageError(fmt::format("--tls-{}: expected --tls-{} beside it, got none", has_key ? "key" : "cert",
                                 has_key ? "cert" : "key"));
  const std::size_t colon = std::min(text.rfind(':'), text.size());
  listen.address = text.substr(0, colon);
  if (text.starts_with('[') && listen.address.ends_with(']')) listen.address = text.substr(1, colon - 2);
  const auto port = parse_number<std::uint16_t>(std::string_view(text).substr(std::min(colon + 1, text.size())));
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(listen.address, error);
  if (error || !port)
    throw UsageError("--listen: expected a numeric address and a port, as 127.0.0.1:8000, got " + in_quotes(text));
  if (!address.is_loopback() && listen.certificate_file.empty())
    throw UsageError("--listen: expected a loopback address, or TLS by --tls-cert, --tls-key, got " + text);
  listen.port = *port;
}

}  // namespace

std::optional<ProgramOptions> parse_options(int argc, const char* const* argv, std::ostream& out) {
  ProgramOptions options;
  std::vector<std::string> fixed;
  CLI::App app("Shows volumes and scenes in the browser, and the board that makes their pictures.", "gicube-view");
  app.footer(kFooter);
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.add_option(
      "INPUT", options.view.inputs,
      "scenes and volumes as gicube-render takes them, builtin:buckyball; the first is shown, and files may be "
      "dropped on the page");
  app.add_option("--fix", fixed,
                 "an option of gicube-render without its dashes, such as transfer-function=ct-bone (flags: on, off); "
                 "repeatable")
      ->take_all()
      ->delimiter('\0')
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  Listen& listen = options.listen;
  std::string text = "127.0.0.1:0";
  app.add_option("--listen", text,
                 "address of the page; port 0 = any free one; 0.0.0.0 or [::] = all of this machine's addresses; other "
                 "addresses than loopback need TLS")
      ->type_name("ADDRESS:PORT")
      ->capture_default_str();
  app.add_option("--tls-cert", listen.certificate_file, "TLS certificate, PEM, for the host names of the page")
      ->type_name("FILE");
  app.add_option("--tls-key", listen.key_file, "its private key, PEM")->type_name("FILE");
  OptionGroup(app, "Options")
      .flag("--open,!--no-open", options.open, "open the page in the default browser (if there is a desktop)");
  add_board_options(app, options.view.board);
  app.remove_option(app.get_option("--stats"));  // the page offers them
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  read_listen(text, listen);
  for (const std::string& each : fixed) {
    const std::size_t equals = each.find('=');
    if (equals == std::string::npos || equals == 0 || each.front() == '-')
      throw UsageError("--fix: expected NAME=VALUE, the name without dashes, got " + in_quotes(each));
    options.view.settings[each.substr(0, equals)] = each.substr(equals + 1);
  }
  return options;
}

}  // namespace gicube::samples::view
