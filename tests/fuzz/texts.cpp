// The board's configuration text and the driver's URIs.
#include "config/config.h"
#include "gicube/error.h"
#include "targets.h"
#include "transport/uri.h"

namespace gicube::fuzz {

// Lines that begin with ! are overrides, as --set takes them; the rest is the text.
void config(Bytes input) {
  std::string text;
  std::vector<std::string> overrides;
  for (std::string_view rest = text_of(input); !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    if (line.starts_with('!')) {
      overrides.emplace_back(line.substr(1));
    } else {
      text.append(line).push_back('\n');
    }
  }
  emu::ParsedConfig parsed = emu::parse_config(text);
  for (const std::string& each : overrides) emu::apply_override(parsed.config, each);
  emu::to_string(parsed.diagnostics);
  const bool good = emu::check(parsed.config, parsed.lines).empty();
  const v1::BoardConfig resolved = emu::resolve(parsed.config);
  const emu::ParsedConfig again = emu::parse_config(emu::config_text(resolved));
  expect(again.diagnostics.empty(), "a resolved configuration's text can be read");
  expect(emu::config_hash(again.config) == emu::config_hash(resolved), "and means the same");
  expect(emu::check(again.config).empty() == good, "and is as good");
}

void uri(Bytes input) {
  try {
    const Uri uri = parse_uri(text_of(input));
    expect(uri.scheme != UriScheme::kTcp || (uri.port != 0 && !uri.host.empty()), "tcp: has a host and a port");
    expect(uri.scheme != UriScheme::kUnix || !uri.path.empty(), "unix: has a path");
    expect(uri.scheme != UriScheme::kPci || uri.path.find('/') == std::string::npos, "pci: names no other file");
    for (const std::string& argument : uri.board_arguments) {
      expect(argument.find('\0') == std::string::npos, "a program's argument holds no zero byte");
    }
  } catch (const BadArgument&) {
  }
}

}  // namespace gicube::fuzz
