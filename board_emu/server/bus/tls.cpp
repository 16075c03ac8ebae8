#include "tls.h"

#include <fmt/format.h>

#include <boost/asio/ssl.hpp>
#include <stdexcept>

namespace gicube::emu {

std::shared_ptr<Tls> make_tls(const std::string& certificate_file, const std::string& key_file) {
  namespace ssl = boost::asio::ssl;
  auto tls = std::make_shared<Tls>(ssl::context::tls_server);
  boost::system::error_code error;
  const auto check = [&error](const std::string& file) {
    if (error) throw std::runtime_error(fmt::format("{}: {}", file, error.message()));
  };
  tls->set_options(ssl::context::default_workarounds | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1, error);
  tls->use_certificate_chain_file(certificate_file, error);
  check(certificate_file);
  tls->use_private_key_file(key_file, ssl::context::pem, error);
  check(key_file);
  return tls;
}

}  // namespace gicube::emu
