// Board URIs: which board Board::open() opens, and how an emulated one is started.
//
//   emu:[?option=value&...]     fidelity, bus, pace, threads, config, set, bsdf, faults, fault_log, trace,
//                               trace_window, events, events_of, capture, restore; set and bsdf may come several times
//   unix:PATH
//   tcp:HOST:PORT               an IPv6 address is written in brackets
//   tls:HOST:PORT               the same with TLS
//   pci:DOMAIN:BUS:SLOT.FUNCTION   a PCI function, as pci:0000:00:04.0; without DOMAIN: 0000
//
// %XX stands for a byte, in paths and option values.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gicube {

enum class UriScheme { kEmu, kUnix, kTcp, kPci };

struct Uri {
  UriScheme scheme = UriScheme::kEmu;
  std::string path;                          // unix; pci: the address, with its domain
  std::string host;                          // tcp, without brackets
  std::uint16_t port = 0;                    // tcp
  bool is_secure = false;                    // tcp: by TLS
  std::vector<std::string> board_arguments;  // emu: arguments of gicube-board, such as "--set", "threads=2"
  std::string capture;                       // emu: the file that the session is captured to
  unsigned threads = 0;                      // emu: 0 = one per core
  bool restores = false;                     // emu: the board starts from a checkpoint
};

// unix:PATH, tcp:HOST:PORT, tls:HOST:PORT or pci:ADDRESS; emu: without its options.
std::string text_of(const Uri& uri);

// Throws BadArgument with the scheme, the option or the value that is wrong.
Uri parse_uri(std::string_view text);

}  // namespace gicube
