#include <cstdlib>

#include "gicube/error.h"
#include "tls_stream.h"

namespace gicube {

std::shared_ptr<Tls> make_tls(const std::string& host) {
  namespace ssl = boost::asio::ssl;
  auto tls = std::make_shared<Tls>();
  tls->host = host;
  boost::system::error_code error;
  tls->context.set_options(ssl::context::default_workarounds | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1,
                           error);
  tls->context.set_verify_mode(ssl::verify_peer, error);
  tls->context.set_verify_callback(ssl::host_name_verification(host), error);
  const char* const file = std::getenv("GICUBE_CA_FILE");
  if (file == nullptr || *file == '\0') {
    tls->context.set_default_verify_paths(error);
    return tls;
  }
  tls->context.load_verify_file(file, error);
  if (error)
    throw BadArgument("GICUBE_CA_FILE", "a file with a certificate, PEM", std::string(file) + ": " + error.message());
  return tls;
}

}  // namespace gicube
