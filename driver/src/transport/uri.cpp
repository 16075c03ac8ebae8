#include "uri.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <regex>
#include <set>
#include <utility>

#include "gicube/error.h"

namespace gicube {
namespace {

// Options with one of several words as value, which set a field of the board's configuration.
struct Choice {
  std::string_view option, field;
  std::initializer_list<std::string_view> words;
  std::string_view old_word{};  // still accepted, for one release
};
const Choice kChoices[] = {{"fidelity", "fidelity", {"functional", "cycle"}, "approximate"},
                           {"pace", "pace", {"as_fast_as_possible", "realtime"}},
                           {"bus", "bus.model", {"pci33", "agp1x", "agp2x", "agp4x"}}};
// Options that name a file, and the board's flag for each. The driver itself writes the capture.
constexpr std::pair<std::string_view, std::string_view> kFiles[] = {
    {"config", "--config"}, {"bsdf", "--bsdf"},     {"faults", "--faults"},   {"fault_log", "--fault-log"},
    {"trace", "--trace"},   {"events", "--events"}, {"restore", "--restore"}, {"capture", ""}};
constexpr unsigned kMaxThreads = 1024;  // chosen: more than any machine has, to detect typing errors

std::string in_quotes(std::string_view text) { return "\"" + std::string(text) + "\""; }

template <typename Number>
std::optional<Number> parse_number(std::string_view text, int base = 10) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string percent_decode(std::string_view text, const std::string& field) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\0') throw BadArgument(field, "text without zero bytes", "one at " + std::to_string(i));
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const auto byte = i + 2 < text.size() ? parse_number<std::uint8_t>(text.substr(i + 1, 2), 16) : std::nullopt;
    if (!byte) throw BadArgument(field, "two hexadecimal digits after each %", in_quotes(text));
    if (*byte == 0) throw BadArgument(field, "no %00", in_quotes(text));
    decoded += static_cast<char>(*byte);
    i += 2;
  }
  return decoded;
}

void check_choice(const std::string& field, std::string_view value, const Choice& choice) {
  if (value == choice.old_word) return;
  std::string expected;
  for (const std::string_view word : choice.words) {
    if (value == word) return;
    expected += (expected.empty() ? "" : ", ") + std::string(word);
  }
  throw BadArgument(field, "one of " + expected, in_quotes(value));
}

void take_option(const std::string& name, const std::string& value, Uri& uri) {
  const std::string field = "URI option " + name;
  const auto pass_on = [&uri](std::string_view flag, const std::string& argument) {
    uri.board_arguments.insert(uri.board_arguments.end(), {std::string(flag), argument});
  };
  for (const Choice& choice : kChoices) {
    if (name != choice.option) continue;
    check_choice(field, value, choice);
    return pass_on("--set", std::string(choice.field) + "=" + value);
  }
  for (const auto& [option, flag] : kFiles) {
    if (name != option) continue;
    if (value.empty()) throw BadArgument(field, "a file name", in_quotes(value));
    uri.restores = uri.restores || name == "restore";
    if (!flag.empty()) return pass_on(flag, value);
    uri.capture = value;
    return;
  }
  if (name == "threads") {
    uri.threads = parse_number<unsigned>(value).value_or(kMaxThreads + 1);
    if (uri.threads > kMaxThreads)
      throw BadArgument(field, fmt::format("a number from 0 to {}", kMaxThreads), in_quotes(value));
    pass_on("--set", fmt::format("threads={}", uri.threads));
  } else if (name == "trace_window" || name == "events_of") {  // the board checks their values
    if (value.empty()) throw BadArgument(field, "a text", in_quotes(value));
    pass_on(name == "events_of" ? "--events-of" : "--trace-window", value);
  } else if (name == "set") {  // the board checks the fields
    const std::size_t equals = value.find('=');
    const bool is_whole = equals != 0 && equals != std::string::npos && equals + 1 != value.size();
    if (!is_whole) throw BadArgument(field, "path.to.field=value", in_quotes(value));
    pass_on("--set", value);
  } else {
    throw BadArgument("URI option",
                      "one of fidelity, bus, pace, threads, config, set, bsdf, faults, fault_log, trace, trace_window, "
                      "events, events_of, capture, restore (boards and buses are options of BoardGroup::open())",
                      in_quotes(name));
  }
}

Uri parse_emu(std::string_view rest) {
  Uri uri;
  if (rest.empty()) return uri;
  if (rest.front() != '?') throw BadArgument("URI", "emu: or emu:?option=value", in_quotes("emu:" + std::string(rest)));
  rest.remove_prefix(1);
  std::set<std::string> seen;
  while (!rest.empty()) {
    const std::string_view item = rest.substr(0, rest.find('&'));
    rest.remove_prefix(item.size() < rest.size() ? item.size() + 1 : item.size());
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos) throw BadArgument("URI option", "option=value", in_quotes(item));
    const std::string name = percent_decode(item.substr(0, equals), "URI option");
    if (name != "set" && name != "bsdf" && !seen.insert(name).second) {
      throw BadArgument("URI option " + name, "to be given once", "it twice");
    }
    take_option(name, percent_decode(item.substr(equals + 1), "URI option " + name), uri);
  }
  return uri;
}

Uri parse_unix(std::string_view rest) {
  if (rest.empty()) throw BadArgument("URI", "unix:PATH", "no path");
  if (rest.find('?') != std::string_view::npos) {
    throw BadArgument("URI", "unix:PATH without options (they are for emu:; %3F stands for ? in a path)",
                      in_quotes("unix:" + std::string(rest)));
  }
  Uri uri;
  uri.scheme = UriScheme::kUnix;
  uri.path = percent_decode(rest, "URI path");
  return uri;
}

Uri parse_tcp(std::string_view rest, bool is_secure) {
  const std::string scheme = is_secure ? "tls:" : "tcp:";
  const auto fail = [&rest, &scheme](const std::string& expected) -> BadArgument {
    return {"URI", expected, in_quotes(scheme + std::string(rest))};
  };
  const std::size_t colon = rest.rfind(':');
  const bool bracketed = rest.starts_with('[');
  if (colon == std::string_view::npos || colon == 0) throw fail(scheme + "HOST:PORT");
  std::string_view host = rest.substr(0, colon);
  if (bracketed) {
    if (!host.ends_with(']') || host.size() < 3) throw fail(scheme + "[IPV6]:PORT");
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    throw fail("an IPv6 address in brackets, " + scheme + "[IPV6]:PORT");
  }
  const auto port = parse_number<std::uint16_t>(rest.substr(colon + 1));
  if (!port || *port == 0) throw fail("a port from 1 to 65535 in " + scheme + "HOST:PORT, and no options");
  Uri uri;
  uri.scheme = UriScheme::kTcp;
  uri.host = percent_decode(host, "URI host");
  uri.port = *port;
  uri.is_secure = is_secure;
  return uri;
}

Uri parse_pci(std::string_view rest) {
  static const std::regex kAddress("([0-9a-f]{4}:)?[0-9a-f]{2}:[01][0-9a-f]\\.[0-7]", std::regex::icase);
  std::string address(rest);
  if (!std::regex_match(address, kAddress)) {
    throw BadArgument("URI", "pci:DOMAIN:BUS:SLOT.FUNCTION, as pci:0000:00:04.0 (lspci -D lists addresses)",
                      in_quotes("pci:" + address));
  }
  if (address.size() < sizeof "0000:00:04.0" - 1) address = "0000:" + address;
  std::ranges::transform(address, address.begin(), [](char c) { return c >= 'A' ? static_cast<char>(c | 0x20) : c; });
  Uri uri;
  uri.scheme = UriScheme::kPci;
  uri.path = address;
  return uri;
}

}  // namespace

std::string text_of(const Uri& uri) {
  if (uri.scheme == UriScheme::kEmu) return "emu:";
  if (uri.scheme == UriScheme::kUnix) return "unix:" + uri.path;
  if (uri.scheme == UriScheme::kPci) return "pci:" + uri.path;
  const bool is_ipv6 = uri.host.find(':') != std::string::npos;
  return fmt::format("{}:{}:{}", uri.is_secure ? "tls" : "tcp", is_ipv6 ? "[" + uri.host + "]" : uri.host, uri.port);
}

Uri parse_uri(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view scheme = text.substr(0, colon);
  if (colon != std::string_view::npos) {
    const std::string_view rest = text.substr(colon + 1);
    if (scheme == "emu") return parse_emu(rest);
    if (scheme == "unix") return parse_unix(rest);
    if (scheme == "pci") return parse_pci(rest);
    if (scheme == "tcp" || scheme == "tls") return parse_tcp(rest, scheme == "tls");
  }
  throw BadArgument("URI", "emu:, unix:PATH, tcp:HOST:PORT, tls:HOST:PORT or pci:ADDRESS", in_quotes(text));
}

}  // namespace gicube
