// The implementation of tls.h with OpenSSL: heavy headers, for few sources.
#pragma once

#include <string>

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/ssl.hpp>

#include "tls.h"

namespace gicube {

class Tls {
 public:
  boost::asio::ssl::context context{boost::asio::ssl::context::tls_client};
  std::string host;
};

using TlsStream = boost::asio::ssl::stream<boost::asio::generic::stream_protocol::socket&>;

}  // namespace gicube
