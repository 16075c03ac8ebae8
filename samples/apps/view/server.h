// HTTP and WebSocket for the pages (protocol.h), by TLS if there is a certificate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "scene/names.h"
#include "view/posted.h"
#include "view/viewer.h"

namespace gicube::samples::view {

struct Listen {
  std::string address = "127.0.0.1";       // numeric; 0.0.0.0 or ::, all of this machine
  std::uint16_t port = 0;                  // any that is free
  std::string certificate_file, key_file;  // PEM; empty: no TLS
};

// The server's interface to a viewer; calls come from the server's thread.
struct Pages {
  std::function<void(Page)> come, leave;
  std::function<void(Page, Request)> ask;
  std::function<std::optional<Viewer::Download>(const std::string& what, std::uint64_t number)> download;
  PostedFiles* files = nullptr;
};

class Server {
 public:
  // From here on signals that end programs end run(): SIGINT, SIGTERM, and SIGHUP unless it is ignored. Throws
  // boost::system::system_error, and FileError for a certificate.
  Server(Pages pages, const Listen& listen, std::string token);
  // For connections that serve() is given; listens nowhere.
  Server(Pages pages, std::string token);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::string address() const;  // with the token

  // Until such a signal, or until what serve() was given has ended.
  void run();
  // From any thread.
  void send(Page page, const Packet& packet);

  // Serves a connected socket, which it then owns, until it is closed. For tests and fuzzers.
  void serve(int descriptor);

  std::size_t connections() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gicube::samples::view
