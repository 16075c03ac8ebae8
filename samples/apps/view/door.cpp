#include "view/door.h"

#include <fmt/format.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <charconv>

#include "gicube/access.h"
#include "gicube/scene/error.h"
#include "scene/names.h"

namespace gicube::samples::view {
namespace {

using boost::beast::http::status;

std::string percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    const char* const digits = text.data() + i + 1;
    unsigned value = 0;
    if (i + 2 >= text.size() || std::from_chars(digits, digits + 2, value, 16).ptr != digits + 2)
      throw Refusal{status::bad_request, "a % without two digits"};
    out += static_cast<char>(value);
    i += 2;
  }
  return out;
}

bool is_certified(boost::asio::ssl::context& tls, const std::string& host) {
  X509* const certificate = SSL_CTX_get0_certificate(tls.native_handle());
  return X509_check_host(certificate, host.data(), host.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(certificate, host.c_str(), 0) == 1;
}

}  // namespace

Target target_of(std::string_view text) {
  Target target;
  const std::size_t query = text.find('?');
  target.path = percent_decoded(text.substr(0, query));
  if (!target.path.starts_with('/')) throw Refusal{status::bad_request, "a target: expected one that begins with /"};
  while (query != std::string_view::npos && !text.empty()) {
    text.remove_prefix(std::min(text.find_first_of("?&"), text.size() - 1) + 1);
    const std::string_view part = text.substr(0, text.find('&'));
    const std::size_t equals = part.find('=');
    if (equals != std::string_view::npos)
      target.query.emplace(percent_decoded(part.substr(0, equals)), percent_decoded(part.substr(equals + 1)));
    if (part.size() == text.size()) break;
  }
  return target;
}

void Door::speak_tls(const std::string& certificate_file, const std::string& key_file) {
  using Context = boost::asio::ssl::context;
  tls = std::make_unique<Context>(Context::tls_server);
  boost::system::error_code error;
  const auto expect = [&error](const std::string& file, const char* what) {
    if (error) throw FileError(file, "TLS", what, error.message());
  };
  tls->set_options(Context::default_workarounds | Context::no_tlsv1 | Context::no_tlsv1_1, error);
  tls->use_certificate_chain_file(certificate_file, error);
  expect(certificate_file, "a certificate, PEM");
  tls->use_private_key_file(key_file, Context::pem, error);
  expect(key_file, "the certificate's private key, PEM");
}

std::string Door::address() const {
  const bool is_v6 = host.find(':') != std::string::npos;
  return fmt::format("{}://{}{}/?token={}", scheme(), is_v6 ? '[' + host + ']' : host, port_suffix(), token);
}

// Whether the name is local, or one of the certificate. A foreign page whose name resolves to this address has another
// Host.
bool Door::is_own(std::string_view named) const {
  if (!named.ends_with(port_suffix())) return false;
  named.remove_suffix(port_suffix().size());
  if (named.starts_with('[') && named.ends_with(']')) named = named.substr(1, named.size() - 2);
  return named == host || named == "127.0.0.1" || named == "localhost" ||
         (tls && is_certified(*tls, std::string(named)));
}

void Door::check(std::string_view named, std::string_view origin, bool changes) const {
  if (!is_own(named)) throw Refusal{status::forbidden, "Host: expected the one in the printed address"};
  if (origin.empty() && !changes) return;
  if (origin != scheme() + "://" + std::string(named))
    throw Refusal{status::forbidden, "Origin: expected that of this page"};
}

void Door::check_token(const Target& target) const {
  if (!right_of({{Right::kUse, token}}, target.value("token")))
    throw Refusal{status::forbidden, "token: expected the one in the printed address"};
}

}  // namespace gicube::samples::view
