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
  // From now on SIGINT, SIGTERM, and SIGHUP unless it is ignored, end run(). Throws boost::system::system_error, and
  // FileError for a certificate.
  Server(Pages pages, const Listen& listen, std::string token);
  // Only for connections passed to serve(); does not listen.
  Server(Pages pages, std::string token);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::string address() const;  // with the token

  // Runs until such a signal, or until all connections passed to serve() have ended.
  void run();
  // May be called from any thread.
  void send(Page page, const Packet& packet);

  // Takes ownership of a connected socket and serves it until it is closed. For tests and fuzzers.
  void serve(int descriptor);

  std::size_t connections() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gicube::samples::view
