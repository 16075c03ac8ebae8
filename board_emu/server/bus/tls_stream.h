// OpenSSL implementation of tls.h. Its headers are heavy, so only few sources include it.
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/ssl.hpp>

#include "tls.h"

namespace gicube::emu {

class Tls {
 public:
  boost::asio::ssl::context context{boost::asio::ssl::context::tls_server};
};

struct TlsStream {
  TlsStream(boost::asio::generic::stream_protocol::socket& socket, Tls& tls) : stream(socket, tls.context) {}

  boost::asio::ssl::stream<boost::asio::generic::stream_protocol::socket&> stream;
  bool is_up = false;  // the TLS handshake has succeeded
};

}  // namespace gicube::emu
