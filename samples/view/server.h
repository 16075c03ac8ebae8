// HTTP and WebSocket for the pages (protocol.h), on this machine's own addresses only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "scene/names.h"
#include "view/viewer.h"

namespace gicube::samples::view {

// 128 bits of the system's random source, as 32 hexadecimal digits.
std::string new_token();

// In a time that does not depend on where they differ.
bool same_secret(std::string_view a, std::string_view b);

// What the server asks of a viewer; calls come from the server's thread.
struct Pages {
  std::function<void(Page)> come, leave;
  std::function<void(Page, Request)> ask;
  std::function<std::optional<Viewer::Download>(const std::string& what, std::uint64_t number)> download;
  std::filesystem::path folder;  // for posted files
};

class Server {
 public:
  // Listens on 127.0.0.1; port 0: any that is free. Throws boost::system::system_error.
  Server(Pages pages, std::uint16_t port, std::string token);
  // For connections that serve() is given; listens nowhere.
  Server(Pages pages, std::string token);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  std::string address() const;  // with the token

  // Until stop(), or a signal that ends programs (SIGINT, SIGTERM).
  void run();
  void stop();
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
