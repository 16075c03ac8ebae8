#include "connect.h"
#include "gicube/error.h"
#include "tls_stream.h"

namespace gicube {

std::shared_ptr<Tls> make_tls(const std::string& host, const std::string& ca_file) {
  namespace ssl = boost::asio::ssl;
  auto tls = std::make_shared<Tls>();
  tls->host = host;
  boost::system::error_code error;
  tls->context.set_options(ssl::context::default_workarounds | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1,
                           error);
  tls->context.set_verify_mode(ssl::verify_peer, error);
  tls->context.set_verify_callback(ssl::host_name_verification(host), error);
  const auto [path, field] = named_file(ca_file, "ca_file", "GICUBE_CA_FILE");
  if (path.empty()) {
    tls->context.set_default_verify_paths(error);
    return tls;
  }
  tls->context.load_verify_file(path, error);
  if (error) throw BadArgument(field, "a file with a certificate, PEM", path + ": " + error.message());
  return tls;
}

}  // namespace gicube
