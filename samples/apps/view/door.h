// Access control: the address, the certificate, and the checks of a request.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/ssl/context.hpp>
#include <boost/beast/http/status.hpp>

namespace gicube::samples::view {

// A refusing answer, with one line of text.
struct Refusal {
  boost::beast::http::status status;
  std::string text;
};

struct Target {
  std::string path;
  std::map<std::string, std::string> query;

  // Empty if there is none.
  std::string value(const std::string& name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::string() : found->second;
  }
};

// Throws Refusal: a % without two digits, or no / at the beginning.
Target target_of(std::string_view text);

struct Door {
  std::string token;
  std::string host = "127.0.0.1";  // of the address; a numeric one without brackets
  std::uint16_t port = 0;
  std::unique_ptr<boost::asio::ssl::context> tls{};  // null: http

  // Enables TLS with this certificate and its private key, PEM files. Throws FileError.
  void speak_tls(const std::string& certificate_file, const std::string& key_file);
  std::string address() const;
  // Checks Host and Origin. `changes`: the request changes something, or gets data that other pages must not get.
  // Throws Refusal.
  void check(std::string_view named, std::string_view origin, bool changes) const;
  void check_token(const Target& target) const;

 private:
  bool is_own(std::string_view named) const;
  std::string scheme() const { return tls ? "https" : "http"; }
  // The port after a host. Browsers omit the scheme's default port.
  std::string port_suffix() const { return port == (tls ? 443 : 80) ? "" : ':' + std::to_string(port); }
};

}  // namespace gicube::samples::view
