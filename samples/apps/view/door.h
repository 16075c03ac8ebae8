// Who gets in: what a request must have, and by which address and certificate it comes.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/ssl/context.hpp>
#include <boost/beast/http/status.hpp>

namespace gicube::samples::view {

// An answer that is not a page's file; its text is one line.
struct Refusal {
  boost::beast::http::status status;
  std::string text;
};

struct Target {
  std::string path;
  std::map<std::string, std::string> query;

  // Empty: there is none.
  std::string value(const std::string& name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::string() : found->second;
  }
};

// Throws Refusal: a % without two digits, or no / at its beginning.
Target target_of(std::string_view text);

struct Door {
  std::string token;
  std::string host = "127.0.0.1";  // of the address; a numeric one without brackets
  std::uint16_t port = 0;
  std::unique_ptr<boost::asio::ssl::context> tls{};  // null: http

  // With this certificate and its private key, PEM files. Throws FileError.
  void speak_tls(const std::string& certificate_file, const std::string& key_file);
  std::string address() const;
  // `changes`: the request changes something, or gets what another page may not. Throws Refusal.
  void check(std::string_view named, std::string_view origin, bool changes) const;
  void check_token(const Target& target) const;

 private:
  bool is_own(std::string_view named) const;
  std::string scheme() const { return tls ? "https" : "http"; }
  // Behind a host; a browser leaves the scheme's own port out.
  std::string port_suffix() const { return port == (tls ? 443 : 80) ? "" : ':' + std::to_string(port); }
};

}  // namespace gicube::samples::view
